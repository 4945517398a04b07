//! Scopes of the frame loop: each is recorded in the trace and, with the feature `tracy`, in Tracy.

use antumbra::gpu::PassTime;
use antumbra::pacing::Time;

/// A scope of the CPU's work.
pub struct Scope {
    /// The name in the trace.
    pub name: &'static str,
    /// The time at which it began.
    pub began: Time,
    #[cfg(feature = "tracy")]
    _zone: Option<tracy_client::Span>,
}

impl Scope {
    /// Begins a scope at `began`, the current time. In Tracy it ends when it is dropped.
    pub fn begin(name: &'static str, began: Time) -> Self {
        Self {
            name,
            began,
            #[cfg(feature = "tracy")]
            _zone: tracy_client::Client::running()
                .map(|client| client.span_alloc(Some(name), "", file!(), line!(), 0)),
        }
    }
}

/// The connection to Tracy for values other than scopes. It listens only on this machine, and
/// stores nothing while no profiler is connected. Without the feature `tracy` there is no thread
/// and no socket.
#[cfg(feature = "tracy")]
pub struct Profiler {
    client: tracy_client::Client,
    plots: Vec<(&'static str, tracy_client::PlotName)>,
}

#[cfg(feature = "tracy")]
impl Profiler {
    /// Starts to listen; may be called once per process.
    pub fn start() -> Self {
        Self { client: tracy_client::Client::start(), plots: Vec::new() }
    }

    /// Marks the submission of a frame, and sends the passes that were read back.
    pub fn frame(&mut self, passes: &[PassTime]) {
        self.client.frame_mark();
        if !tracy_client::Client::is_connected() {
            return;
        }
        for pass in passes {
            let place = self.plots.iter().position(|(label, _)| *label == pass.label);
            let place = place.unwrap_or_else(|| {
                // Names are never freed; there is one per label.
                let name = tracy_client::PlotName::new_leak(format!("GPU {} (ms)", pass.label));
                self.plots.push((pass.label, name));
                self.plots.len() - 1
            });
            self.client.plot(self.plots[place].1, pass.gpu_ms);
        }
    }
}

/// The connection without Tracy.
#[cfg(not(feature = "tracy"))]
pub struct Profiler;

#[cfg(not(feature = "tracy"))]
impl Profiler {
    /// Does nothing: this build has no profiler.
    pub fn start() -> Self {
        Self
    }

    /// Drops the times of a frame.
    pub fn frame(&mut self, _: &[PassTime]) {}
}

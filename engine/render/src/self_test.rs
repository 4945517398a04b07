//! The self-test: checks the assumptions about a driver that exact images depend on, by small
//! purpose-built frames and a short walk with each tester. It takes about a second.

mod check_result;
mod judge;
mod probe;
mod probe_scene;
mod walk;

use cull::Strategy;
use gpu::{Device, PredicationMode, ResultSource};
use occlusion::{DriverAssumption, DriverQuirks, Rect, ShaderSet};

pub use check_result::CheckResult;

use crate::error::Error;
use crate::renderer::RendererOptions;
use judge::CountsSamples;
use probe::Probe;
use probe_scene::{PROBES, TWINS};

/// The outcome of a [self-test](self_test): each assumption with the result of its check.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SelfTest {
    /// A result for each assumption, in the order of [`DriverAssumption::ALL`].
    pub findings: Vec<(DriverAssumption, CheckResult)>,
    /// The strategy with the safest tester that can be trusted: `antumbra` itself if everything
    /// that it may use can be trusted. `None` if every tester or every executor is broken: then
    /// only plain frustum culling gives correct images.
    pub safest: Option<Strategy>,
}

impl SelfTest {
    /// Returns the assumptions that do not hold, for
    /// [`RendererOptions::disabled`](crate::RendererOptions::disabled).
    #[must_use]
    pub fn broken(&self) -> Vec<DriverAssumption> {
        let is_broken =
            |(_, verdict): &&(_, CheckResult)| matches!(verdict, CheckResult::Failed(_));
        self.findings.iter().filter(is_broken).map(|(assumption, _)| *assumption).collect()
    }

    /// Returns the result for an assumption; `None` if it was not checked.
    #[must_use]
    pub fn verdict(&self, assumption: DriverAssumption) -> Option<&CheckResult> {
        self.findings.iter().find(|(tested, _)| *tested == assumption).map(|(_, verdict)| verdict)
    }
}

/// Tests the driver of a device, with the shaders of `options`, or else the embedded ones.
/// Everything else in `options` is ignored. Waits for the device many times: call it before the
/// first frame, and keep its outcome for
/// [`RendererOptions::disabled`](crate::RendererOptions::disabled).
///
/// # Errors
/// No memory, a shader that does not compile, a failed call, a lost device. A fault of the driver
/// is not an error but a result.
pub fn self_test(device: &Device, options: &RendererOptions) -> Result<SelfTest, Error> {
    let shaders = match &options.shaders {
        Some(shaders) => shaders.clone(),
        None => ShaderSet::embedded()?,
    };
    let plain = RendererOptions { shaders: Some(shaders.clone()), ..RendererOptions::default() };
    let mut checks = Checks { findings: Vec::new(), device: device.clone() };
    let mut probe = Probe::new(device, &plain)?;
    let whole = probe.whole_image()?;
    let pixels = judge::drawn_pixels(&whole);
    checks.queries(&mut probe, &pixels, &judge::drawn_areas(&whole))?;
    checks.flags(&mut probe, &pixels)?;
    checks.compute(&mut probe, &pixels, &shaders)?;
    checks.executors(&mut probe, &pixels, &shaders)?;
    checks.order(&mut probe)?;
    drop(probe);
    checks.repeated_depth(&plain, &pixels)?;
    checks.walks(&plain)?;
    let Checks { findings, .. } = checks;
    let mut outcome = SelfTest { findings, safest: None };
    outcome.safest = safest(&outcome.broken(), device);
    Ok(outcome)
}

/// Returns the strategy with the safest tester, if there is one.
fn safest(broken: &[DriverAssumption], device: &Device) -> Option<Strategy> {
    let quirks = DriverQuirks::new(broken);
    let has = |executor: PredicationMode| executor.is_supported(device);
    let executor = quirks.executor(PredicationMode::Conditional, has)?;
    let testers = quirks.testers(walk::offered(device), executor);
    let strategy = testers.strategy(Strategy::ANTUMBRA);
    (strategy != Strategy::FRUSTUM).then_some(strategy)
}

/// The results so far.
struct Checks {
    device: Device,
    findings: Vec<(DriverAssumption, CheckResult)>,
}

impl Checks {
    fn note(&mut self, assumption: DriverAssumption, verdict: CheckResult) {
        if let CheckResult::Failed(observation) = &verdict {
            tracing::warn!("this driver cannot be trusted with {assumption}: {observation}");
        }
        self.findings.push((assumption, verdict));
    }

    fn not_tested(&mut self, assumptions: &[DriverAssumption], reason: &str) {
        for assumption in assumptions {
            self.note(*assumption, CheckResult::Skipped(reason.to_owned()));
        }
    }

    /// Checks the counts of queries, and by these that proxies enclose their objects.
    fn queries(&mut self, probe: &mut Probe, pixels: &[u32], areas: &[Rect]) -> Result<(), Error> {
        let found = probe.by_queries(areas)?;
        let counts = if probe.can_count() { CountsSamples::Exactly } else { CountsSamples::No };
        let verdict = judge::query_counts(pixels, &found, counts);
        let are_right = verdict == CheckResult::Passed;
        self.note(DriverAssumption::QueryCounts, verdict);
        let [wrong, all] = probe.late_results()?;
        let late = CheckResult::of_faults(wrong, all, "results are not those of their frame");
        self.note(DriverAssumption::LateResults, late);
        if !are_right {
            let geometry = [DriverAssumption::ProxyCoverage, DriverAssumption::ProxyDepth];
            self.not_tested(&geometry, "it is measured by queries, which are broken");
            return Ok(());
        }
        let coverage = "proxies leave out samples of their objects";
        let coverage = judge::enclosing(pixels, &found.alone, counts, coverage);
        self.note(DriverAssumption::ProxyCoverage, coverage);
        let depth = "proxies are behind their objects";
        let depth = judge::enclosing(pixels, &found.proxies, counts, depth);
        self.note(DriverAssumption::ProxyDepth, depth);
        Ok(())
    }

    fn flags(&mut self, probe: &mut Probe, pixels: &[u32]) -> Result<(), Error> {
        match probe.by_flags()? {
            Some(found) => {
                let hidden = judge::hidden_proxies(pixels, &found, "flags");
                self.note(DriverAssumption::EarlyTests, hidden);
                let shown = judge::shown_proxies(pixels, &found, "flags");
                self.note(DriverAssumption::FlagWrites, shown);
            }
            None => {
                let reason = "fragment shaders of this device cannot write to buffers";
                self.not_tested(
                    &[DriverAssumption::EarlyTests, DriverAssumption::FlagWrites],
                    reason,
                );
            }
        }
        Ok(())
    }

    fn compute(
        &mut self,
        probe: &mut Probe,
        pixels: &[u32],
        shaders: &ShaderSet,
    ) -> Result<(), Error> {
        let verdict = match probe.by_compute(shaders)? {
            None => CheckResult::Skipped("this device has no compute tester".to_owned()),
            Some(found) => match judge::shown_proxies(pixels, &found, "the compute tester") {
                CheckResult::Passed => judge::hidden_proxies(pixels, &found, "the compute tester"),
                broken => broken,
            },
        };
        self.note(DriverAssumption::ComputedDepths, verdict);
        Ok(())
    }

    /// Checks each executor with each kind of result.
    fn executors(
        &mut self,
        probe: &mut Probe,
        pixels: &[u32],
        shaders: &ShaderSet,
    ) -> Result<(), Error> {
        for executor in PredicationMode::ALL {
            let assumption = match executor {
                PredicationMode::Conditional => DriverAssumption::ConditionalRendering,
                PredicationMode::Counts => DriverAssumption::DrawCounts,
                PredicationMode::Instances => DriverAssumption::InstanceCounts,
                PredicationMode::Compacted => DriverAssumption::CompactedLists,
            };
            if !executor.is_supported(&self.device) {
                self.not_tested(&[assumption], "this device does not have it");
                continue;
            }
            let mut verdict = CheckResult::Passed;
            for source in [ResultSource::Queries, ResultSource::Fragments] {
                // If the results of a source cannot be trusted, they say nothing about executors.
                let is_broken = self.findings.iter().any(|(tested, verdict)| {
                    let writes = match source {
                        ResultSource::Queries => DriverAssumption::QueryCounts,
                        _ => DriverAssumption::FlagWrites,
                    };
                    *tested == writes && matches!(verdict, CheckResult::Failed(_))
                });
                if is_broken || verdict != CheckResult::Passed {
                    continue;
                }
                if let Some(image) = probe.predicated(executor, source, shaders)? {
                    verdict = judge::predicated(pixels, &judge::drawn_pixels(&image), source);
                }
            }
            self.note(assumption, verdict);
        }
        Ok(())
    }

    /// Checks the order of draws with equal depth: objects and their twins are drawn at the same
    /// place, in one call and in two.
    fn order(&mut self, probe: &mut Probe) -> Result<(), Error> {
        let objects = 0..TWINS;
        let twins = PROBES..PROBES + TWINS;
        let [first, last] =
            [objects.clone(), twins.clone()].map(|object| probe.image_of(&[object]));
        let first = first?;
        let last = last?;
        let [all, without_twins] = [PROBES + TWINS, PROBES].map(|end| 0..end);
        let together = probe.image_of(&[all])?;
        let alone = probe.image_of(&[without_twins])?;
        let apart = probe.image_of(&[twins, objects])?;
        let broken = |what: &str| CheckResult::Failed(what.to_owned());
        let verdict = match (together == alone, apart == last, first == last) {
            (_, _, true) => broken("two colours look the same"),
            (false, _, _) => broken("of two draws of one call the later one wins"),
            (_, false, _) => broken("of two calls the later one wins"),
            (true, true, false) => CheckResult::Passed,
        };
        self.note(DriverAssumption::DrawOrder, verdict);
        Ok(())
    }

    /// Checks that the pass that shades finds the depth again that a depth pass drew.
    fn repeated_depth(&mut self, options: &RendererOptions, pixels: &[u32]) -> Result<(), Error> {
        let found = judge::shaded_pixels(&walk::shaded_probes(&self.device, options)?);
        let lost = pixels.iter().zip(&found).filter(|(expected, found)| expected != found).count();
        let sentence = "objects lose pixels between their depth and their colour";
        self.note(
            DriverAssumption::RepeatedDepth,
            CheckResult::of_faults(lost, pixels.len(), sentence),
        );
        Ok(())
    }

    /// Checks walks with each tester against plain frustum culling.
    fn walks(&mut self, options: &RendererOptions) -> Result<(), Error> {
        let walks = [
            (DriverAssumption::QueriedWalk, Strategy::ANTUMBRA_QUERIES),
            (DriverAssumption::FlaggedWalk, Strategy::ANTUMBRA_FLAGS),
            (DriverAssumption::ComputedWalk, Strategy::ANTUMBRA_COMPUTE),
        ];
        let broken: Vec<DriverAssumption> =
            SelfTest { findings: self.findings.clone(), safest: None }.broken();
        // Uses the executor that would be chosen; otherwise each walk would show the faults of a
        // broken one.
        let quirks = DriverQuirks::new(&broken);
        let has = |executor: PredicationMode| executor.is_supported(&self.device);
        let Some(executor) =
            quirks.executor(PredicationMode::best(self.device.capabilities()), has)
        else {
            let reason = "draws cannot be skipped in any way";
            self.not_tested(&walks.map(|(assumption, _)| assumption), reason);
            return Ok(());
        };
        let options = RendererOptions { predication: Some(executor), ..options.clone() };
        for ((assumption, _), verdict) in walks.into_iter().zip(walk::walks(
            &self.device,
            &options,
            walks.map(|(_, strategy)| strategy),
        )?) {
            self.note(assumption, verdict);
        }
        Ok(())
    }
}

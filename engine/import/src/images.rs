//! The images of a file, decoded to four bytes per pixel or to compressed blocks. Several are
//! decoded at the same time, within a limited amount of memory.

mod gate;
mod jpeg;
mod ktx2_image;
mod pixels;
mod placeholders;

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::Mutex;
use std::sync::PoisonError;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;

use gate::Gate;
use gltf::json::Root;
use ktx2_image::EncodedKtx2;
use pixels::EncodedPixels;
use placeholders::{consequence, placeholder, slots_of_images};
use scene::{Image, Texels};

use crate::buffers::Budget;
use crate::element::Kind;
use crate::elements::Store;
use crate::error::{At, Fault, Reason};
use crate::memory;
use crate::progress::ReadProgress;
use crate::uri::Wanted;
use crate::verdict::Verdict;
use crate::{ImportError, Limits};

/// The most decoding threads: more threads gain little and take memory.
const MAX_THREADS: usize = 8;

/// The images of the shown scene.
pub(crate) struct Images {
    /// One entry per image of the file; `None` if it is not shown.
    pub(crate) list: Vec<Option<Image>>,
    /// The indices of images that could not be read.
    pub(crate) placeholders: BTreeSet<usize>,
}

/// The file whose images are decoded.
pub(crate) struct EncodedImages<'a> {
    pub(crate) root: &'a Root,
    pub(crate) store: &'a Store,
    /// The image of each texture.
    pub(crate) texture_images: &'a [Option<usize>],
    /// The folder to which URIs are relative.
    pub(crate) folder: Option<&'a Path>,
    pub(crate) limits: &'a Limits,
}

/// Decodes the images that shown materials use; the others stay `None`. Images that cannot be read
/// become placeholders, with a note.
pub(crate) fn decode(
    file: &EncodedImages<'_>,
    budget: &mut Budget,
    verdict: &mut Verdict,
    read_progress: &mut ReadProgress<'_>,
) -> Result<Images, Fault> {
    let &EncodedImages { root, store, texture_images, folder, limits } = file;
    let used: BTreeSet<usize> = texture_images.iter().flatten().copied().collect();
    let mut list = vec![None; root.images.len()];
    let mut jobs = Vec::new();
    let mut total: u64 = 0;
    for &index in &used {
        let element = Kind::Image.at(index);
        if verdict.fault_of(root, element).is_some() {
            continue;
        }
        let job = encoded(root, store, index, folder, budget)
            .and_then(|encoded| Job::new(index, encoded, limits))
            .at(|| element.to_string());
        let Some(job) = verdict.judge(element, job)? else { continue };
        total = total.saturating_add(job.head.bytes);
        if total > limits.image_bytes {
            let reason = Reason::too_large("bytes of pixels up to it", total, limits.image_bytes);
            return Err(reason.of(element.to_string()));
        }
        jobs.push(job);
    }
    for (job, texels) in jobs.iter().zip(decode_all(&jobs, limits, read_progress)) {
        let element = Kind::Image.at(job.index);
        let texels = verdict.judge(element, texels.at(|| element.to_string()))?;
        let name = root.images.get(job.index).and_then(|image| image.name.clone());
        let name = name.unwrap_or_else(|| element.to_string());
        if let Some((image, texels)) = list.get_mut(job.index).zip(texels) {
            *image = Some(Image { name, size: job.head.size, texels });
        }
    }
    let mut placeholders = BTreeSet::new();
    let none = BTreeSet::new();
    let slots = if verdict.has_faults() {
        slots_of_images(root, texture_images, verdict)
    } else {
        BTreeMap::new()
    };
    for &index in &used {
        let fault = verdict.fault_of(root, Kind::Image.at(index)).cloned();
        if let Some((image, fault)) = list.get_mut(index).zip(fault) {
            *image = Some(placeholder(index));
            placeholders.insert(index);
            let text = consequence(root, index, slots.get(&index).unwrap_or(&none));
            verdict.repair(fault, &text)?;
        }
    }
    Ok(Images { list, placeholders })
}

/// Returns the encoded bytes of an image.
fn encoded<'a>(
    root: &Root,
    store: &'a Store,
    index: usize,
    folder: Option<&Path>,
    budget: &mut Budget,
) -> Result<Cow<'a, [u8]>, Reason> {
    let image = root.images.get(index);
    if let Some(view) = image.and_then(|image| image.buffer_view) {
        return Ok(Cow::Borrowed(store.view(root, view.value())));
    }
    match image.and_then(|image| image.uri.as_deref()) {
        Some(uri) => budget.fetch(uri, folder, Wanted::All).map(Cow::Owned),
        None => Err(Reason::malformed("it has neither a URI nor a buffer view")),
    }
}

/// An image to decode.
struct Job<'a> {
    index: usize,
    encoded: Cow<'a, [u8]>,
    head: ImageHead,
    coding: Coding,
}

/// The values in the header of an image, which are checked before memory is allocated.
struct ImageHead {
    size: [u32; 2],
    /// The number of bytes of the decoded image.
    bytes: u64,
    /// The memory that decoding takes in addition to the result.
    scratch_bytes: u64,
}

/// The encoding of an image in a file.
enum Coding {
    Pixels(EncodedPixels),
    Ktx2(EncodedKtx2),
}

impl<'a> Job<'a> {
    /// Reads the header of an image.
    fn new(index: usize, encoded: Cow<'a, [u8]>, limits: &Limits) -> Result<Self, Reason> {
        let (head, coding) = guarded(|| {
            if EncodedKtx2::is_in(&encoded) {
                let (head, texels) = EncodedKtx2::read(&encoded)?;
                return Ok((head, Coding::Ktx2(texels)));
            }
            let (head, pixels) = EncodedPixels::read(&encoded, limits)?;
            Ok((head, Coding::Pixels(pixels)))
        })?;
        let [width, height] = head.size;
        if width == 0 || height == 0 {
            return Err(Reason::malformed("it has no pixels"));
        }
        let longest = width.max(height);
        if longest > limits.image_side {
            let text = format!("pixels along a side of {width} x {height}");
            return Err(Reason::too_large(&text, u64::from(longest), u64::from(limits.image_side)));
        }
        if head.scratch_bytes > limits.image_scratch_bytes {
            let text = format!("bytes for decoding {width} x {height} pixels");
            let limit = limits.image_scratch_bytes;
            return Err(Reason::too_large(&text, head.scratch_bytes, limit));
        }
        Ok(Self { index, encoded, head, coding })
    }

    fn run(&self, limits: &Limits) -> Result<Texels, Reason> {
        memory::ask(self.head.scratch_bytes)?;
        guarded(|| match &self.coding {
            Coding::Pixels(pixels) => {
                pixels.decode(&self.encoded, self.head.size, limits).map(Texels::Rgba8)
            }
            Coding::Ktx2(texels) => texels.decode(&self.encoded),
        })
    }
}

/// Calls third-party code; a panic in it only loses this image.
fn guarded<T>(decode: impl FnOnce() -> Result<T, Reason>) -> Result<T, Reason> {
    let decoded = catch_unwind(AssertUnwindSafe(decode));
    decoded.unwrap_or_else(|_| Err(Reason::damaged("its decoder gave up")))
}

/// Decodes an image in memory: PNG, JPEG, WebP, or KTX2 with BC1 to BC5, BC7, ASTC or pixels of one
/// to four channels of eight bits, as in glTF files. `name` is its name in the scene and in errors.
///
/// # Errors
/// An unsupported format, a broken image, or an image beyond the limits.
pub fn decode_image(name: &str, encoded: &[u8], limits: &Limits) -> Result<Image, ImportError> {
    let job = Job::new(0, Cow::Borrowed(encoded), limits).and_then(|job| {
        if job.head.bytes > limits.image_bytes {
            return Err(Reason::too_large("bytes of it", job.head.bytes, limits.image_bytes));
        }
        Ok((job.head.size, job.run(limits)?))
    });
    let (size, texels) = job.map_err(|reason| reason.of("image").in_file(name))?;
    Ok(Image { name: name.to_owned(), size, texels })
}

/// Decodes all images on a limited number of threads, and reports progress after each image. The
/// results are in the order of the jobs.
fn decode_all(
    jobs: &[Job],
    limits: &Limits,
    read_progress: &mut ReadProgress<'_>,
) -> Vec<Result<Texels, Reason>> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    // A thread for a single image costs time and memory, and gains nothing.
    let threads = if jobs.len() > 1 { cores.min(MAX_THREADS).min(jobs.len()) } else { 0 };
    let gate = Gate::new(limits.image_scratch_bytes);
    let next = AtomicUsize::new(0);
    let done = Mutex::new(vec![Err(Reason::given_up()); jobs.len()]);
    let (finished, arriving) = mpsc::channel();
    let work = |finished: mpsc::Sender<()>| {
        while let Some((index, job)) = take(jobs, &next) {
            let texels = gate.with(job.head.scratch_bytes, || job.run(limits));
            let mut done = done.lock().unwrap_or_else(PoisonError::into_inner);
            if let Some(slot) = done.get_mut(index) {
                *slot = texels;
            }
            // The receiver is gone if the progress function stopped loading.
            let _listens = finished.send(());
        }
    };
    std::thread::scope(|scope| {
        let work = &work;
        let start = |finished: mpsc::Sender<()>| {
            std::thread::Builder::new().spawn_scoped(scope, move || work(finished)).is_ok()
        };
        let started = (0..threads).take_while(|_| start(finished.clone())).count();
        // Each thread has a sender; the channel closes when the last one ends. Without threads,
        // this thread does the work.
        match started {
            0 => work(finished),
            _ => drop(finished),
        }
        for (count, ()) in (1..).zip(&arriving) {
            if read_progress(count as f32 / jobs.len() as f32).is_break() {
                // Running jobs finish; no new job begins.
                next.store(jobs.len(), Ordering::Relaxed);
                break;
            }
        }
    });
    done.into_inner().unwrap_or_else(PoisonError::into_inner)
}

fn take<'a, 'b>(jobs: &'a [Job<'b>], next: &AtomicUsize) -> Option<(usize, &'a Job<'b>)> {
    let index = next.fetch_add(1, Ordering::Relaxed);
    jobs.get(index).map(|job| (index, job))
}

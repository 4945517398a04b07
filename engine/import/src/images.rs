//! Images of a file, decoded to four bytes per pixel: several at once, within a stated amount of
//! memory.

mod gate;
mod jpeg;

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::io::Cursor;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::Mutex;
use std::sync::PoisonError;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;

use gate::Gate;
use gltf::json::Root;
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader};
use scene::Image;

use crate::Limits;
use crate::buffers::Budget;
use crate::element::Kind;
use crate::elements::Store;
use crate::error::{At, Fault, Reason, quoted};
use crate::memory;
use crate::progress::ReadProgress;
use crate::uri::Wanted;
use crate::verdict::Verdict;

/// The most decoding threads: more gain little and take memory.
const MAX_THREADS: usize = 8;

/// The images that are shown.
pub(crate) struct Images {
    /// One entry per image of the file; `None` where nothing shows it.
    pub(crate) list: Vec<Option<Image>>,
    /// The indices of those that could not be read.
    pub(crate) placeholders: BTreeSet<usize>,
}

/// Decodes the images that materials show; the others stay `None`. Images that cannot be read
/// become placeholders, with a note.
///
/// # Errors
/// Images beyond the limits; a progress function that stopped the loading.
pub(crate) fn decode(
    root: &Root,
    store: &Store,
    (texture_images, folder): (&[Option<usize>], Option<&Path>),
    (budget, limits): (&mut Budget, &Limits),
    (verdict, read_progress): (&mut Verdict, &mut ReadProgress<'_>),
) -> Result<Images, Fault> {
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
        total = total.saturating_add(job.pixel_bytes());
        if total > limits.image_bytes {
            let reason = Reason::too_large("bytes of pixels up to it", total, limits.image_bytes);
            return Err(reason.of(element.to_string()));
        }
        jobs.push(job);
    }
    for (job, pixels) in jobs.iter().zip(decode_all(&jobs, limits, read_progress)) {
        let element = Kind::Image.at(job.index);
        let rgba8 = verdict.judge(element, pixels.at(|| element.to_string()))?;
        let name = root.images.get(job.index).and_then(|image| image.name.clone());
        let name = name.unwrap_or_else(|| element.to_string());
        if let Some((image, rgba8)) = list.get_mut(job.index).zip(rgba8) {
            *image = Some(Image { name, size: job.size, rgba8 });
        }
    }
    let mut placeholders = BTreeSet::new();
    for &index in &used {
        let fault = verdict.fault_of(root, Kind::Image.at(index)).cloned();
        if let Some((image, fault)) = list.get_mut(index).zip(fault) {
            *image = Some(placeholder(index));
            placeholders.insert(index);
            let shown = root.images.get(index).and_then(|image| image.uri.as_deref());
            let shown = shown.filter(|uri| !uri.starts_with("data:")).map(quoted);
            let shown = shown.map(|uri| format!(" ({uri})")).unwrap_or_default();
            let text = format!("checkers are shown for image {index}{shown}");
            verdict.note_left_out(fault, &text);
        }
    }
    Ok(Images { list, placeholders })
}

/// Returns an image that nobody takes for one of the scene: checkers of magenta and black.
fn placeholder(index: usize) -> Image {
    const SIDE: u32 = 16;
    let texel = |place: u32| {
        let is_dark = (place % SIDE / 4 + place / SIDE / 4).is_multiple_of(2);
        if is_dark { [0, 0, 0, 255] } else { [255, 0, 255, 255] }
    };
    let rgba8 = (0..SIDE * SIDE).flat_map(texel).collect();
    Image { name: format!("image {index} (missing)"), size: [SIDE; 2], rgba8 }
}

/// Returns the encoded bytes of an image in the file.
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
    format: ImageFormat,
    size: [u32; 2],
    /// The memory that decoding takes beside the result.
    scratch_bytes: u64,
    /// True for a JPEG without its last marker.
    lacks_end: bool,
}

impl<'a> Job<'a> {
    /// Reads the head of an image alone: its size is checked before any memory is taken for it.
    fn new(index: usize, encoded: Cow<'a, [u8]>, limits: &Limits) -> Result<Self, Reason> {
        let format = format_of(&encoded)?;
        let (width, height, raw_bytes) = {
            let decoder = decoder(&encoded, format, limits)?;
            let (width, height) = decoder.dimensions();
            (width, height, decoder.total_bytes())
        };
        if width == 0 || height == 0 {
            return Err(Reason::malformed("it has no pixels"));
        }
        let longest = width.max(height);
        if longest > limits.image_side {
            let text = format!("pixels along a side of {width} x {height}");
            return Err(Reason::too_large(&text, u64::from(longest), u64::from(limits.image_side)));
        }
        let jpeg = (format == ImageFormat::Jpeg).then(|| jpeg::inspect(&encoded));
        let copies = match (format, jpeg) {
            // Coefficients of 16 bits for all of the image.
            (_, Some(jpeg)) if jpeg.is_progressive => 4,
            (ImageFormat::Png, _) => 1,
            _ => 2,
        };
        let lacks_end = jpeg.is_some_and(|jpeg| !jpeg.has_end);
        let pixel_bytes = u64::from(width).saturating_mul(u64::from(height)).saturating_mul(4);
        let more_bytes = if lacks_end { pixel_bytes + encoded.len() as u64 } else { 0 };
        let scratch_bytes = raw_bytes.saturating_mul(copies).saturating_add(encoded.len() as u64);
        let scratch_bytes = scratch_bytes.saturating_add(more_bytes);
        if scratch_bytes > limits.image_scratch_bytes {
            let text = format!("bytes for decoding {width} x {height} pixels");
            return Err(Reason::too_large(&text, scratch_bytes, limits.image_scratch_bytes));
        }
        Ok(Self { index, format, size: [width, height], scratch_bytes, lacks_end, encoded })
    }

    fn pixel_bytes(&self) -> u64 {
        u64::from(self.size[0]) * u64::from(self.size[1]) * 4
    }

    fn run(&self, limits: &Limits) -> Result<Vec<u8>, Reason> {
        memory::ask(self.scratch_bytes)?;
        if !self.lacks_end {
            return self.pixels(&self.encoded, limits);
        }
        // The decoder fills up missing data without a warning. In a complete file, bytes after the
        // end change nothing.
        let [one, other] = jpeg::endings(&self.encoded);
        let pixels = self.pixels(&one, limits)?;
        drop(one);
        if self.pixels(&other, limits).as_ref() == Ok(&pixels) {
            return Ok(pixels);
        }
        Err(Reason::damaged("it is a JPEG that is cut off"))
    }

    fn pixels(&self, encoded: &[u8], limits: &Limits) -> Result<Vec<u8>, Reason> {
        // The decoders are third-party code: a panic in one loses this image alone.
        let decoded = catch_unwind(AssertUnwindSafe(|| {
            let decoder = decoder(encoded, self.format, limits)?;
            DynamicImage::from_decoder(decoder)
                .map(DynamicImage::into_rgba8)
                .map_err(|error| undecodable(&error))
        }));
        let pixels = decoded.unwrap_or_else(|_| Err(Reason::damaged("its decoder gave up")))?;
        if pixels.dimensions() != (self.size[0], self.size[1]) {
            return Err(Reason::malformed("its size is not what its head says"));
        }
        Ok(pixels.into_raw())
    }
}

fn format_of(encoded: &[u8]) -> Result<ImageFormat, Reason> {
    const KTX2: &[u8] = b"\xABKTX 20\xBB";
    if encoded.starts_with(KTX2) {
        return Err(Reason::unsupported("it is a KTX2 image; PNG, JPEG and WebP are supported"));
    }
    match image::guess_format(encoded) {
        Ok(format @ (ImageFormat::Png | ImageFormat::Jpeg | ImageFormat::WebP)) => Ok(format),
        _ => Err(Reason::unsupported("it is no PNG, JPEG or WebP image")),
    }
}

fn decoder<'a>(
    encoded: &'a [u8],
    format: ImageFormat,
    limits: &Limits,
) -> Result<impl ImageDecoder + 'a, Reason> {
    let mut reader = ImageReader::with_format(Cursor::new(encoded), format);
    let mut memory = image::Limits::no_limits();
    memory.max_alloc = Some(limits.image_scratch_bytes);
    reader.limits(memory);
    reader.into_decoder().map_err(|error| undecodable(&error))
}

fn undecodable(error: &image::ImageError) -> Reason {
    let said = error.to_string();
    let text = format!("it cannot be decoded: {}", said.trim());
    match error {
        image::ImageError::Limits(_) => Reason::beyond_limits(text),
        _ => Reason::damaged(text),
    }
}

/// Decodes all images on a bounded number of threads, and reports progress after each. The results
/// are in the order of the jobs.
fn decode_all(
    jobs: &[Job],
    limits: &Limits,
    read_progress: &mut ReadProgress<'_>,
) -> Vec<Result<Vec<u8>, Reason>> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let threads = cores.min(MAX_THREADS).min(jobs.len());
    let gate = Gate::new(limits.image_scratch_bytes);
    let next = AtomicUsize::new(0);
    let done = Mutex::new(vec![Err(Reason::given_up()); jobs.len()]);
    let (finished, arriving) = mpsc::channel();
    let work = |finished: mpsc::Sender<()>| {
        while let Some((index, job)) = take(jobs, &next) {
            let pixels = gate.with(job.scratch_bytes, || job.run(limits));
            let mut done = done.lock().unwrap_or_else(PoisonError::into_inner);
            if let Some(slot) = done.get_mut(index) {
                *slot = pixels;
            }
            // Nobody receives results after the progress function stopped the loading.
            let _listens = finished.send(());
        }
    };
    std::thread::scope(|scope| {
        let work = &work;
        let start = |finished: mpsc::Sender<()>| {
            std::thread::Builder::new().spawn_scoped(scope, move || work(finished)).is_ok()
        };
        let started = (0..threads).take_while(|_| start(finished.clone())).count();
        // The threads have one sender each; the channel closes with the last of them. A machine
        // without a spare thread uses this one.
        match started {
            0 => work(finished),
            _ => drop(finished),
        }
        for (count, ()) in (1..).zip(&arriving) {
            if read_progress(count as f32 / jobs.len() as f32).is_break() {
                // Jobs that have begun are finished; no other begins.
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

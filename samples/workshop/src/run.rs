//! Runs the program from the command line to the report.

use std::ops::ControlFlow;
use std::path::Path;

use antumbra::Camera;
use antumbra::import::{LoadOptions, ScenePlace};
use bench::choices::DeviceChoice;
use bench::outputs::{OutputFile, Outputs, write_file};
use bench::run::{open_device, open_instance, pick_adapter};
use bench::run_error::RunError;
use bench::scene_file;
use bench::terminal::Ending;
use bench::terminal::output::say_wrote;

use crate::args::WorkshopArguments;
use crate::document::{CurvedPart, Document, Lid};
use crate::file_parts::{file_bodies, file_parts};
use crate::inputs::{files_of, keep_inputs, keep_outputs};
use crate::report::{CommandOutcome, ScriptReport, ScriptStep};
use crate::script::{self, ScriptLine};
use crate::session::WorkshopSession;
use crate::window;

/// The version of the report's format.
const REPORT_VERSION: u32 = 1;

/// The default number of parts of the assembly.
const ASSEMBLY_PARTS: u32 = 1000;

/// A model and the path of its camera.
pub(crate) struct Model {
    pub(crate) document: Document,
    pub(crate) path: Vec<Camera>,
}

/// Runs the script of the arguments, or opens a window without one.
///
/// # Errors
/// An invalid command line, script or file; no display; a failure of the device.
pub fn run(arguments: &WorkshopArguments, ending: &mut Ending) -> Result<(), RunError> {
    arguments.check()?;
    match &arguments.script {
        Some(script) => carry_out(arguments, script, ending),
        None => window::app::run(arguments, ending),
    }
}

/// Runs a script and writes its report. A refused command counts as a failure of the run, but the
/// following commands are carried out.
fn carry_out(
    arguments: &WorkshopArguments,
    script: &Path,
    ending: &mut Ending,
) -> Result<(), RunError> {
    let lines = script::read(script)?;
    let report_file = OutputFile::of("--report", arguments.report.as_deref());
    let written: Vec<&Path> = lines.iter().filter_map(|line| line.command.written_file()).collect();
    keep_outputs(arguments.report.as_deref(), &written)?;
    let written = written.iter().filter_map(|file| OutputFile::of("--script", Some(file)));
    let files: Vec<OutputFile<'_>> = report_file.into_iter().chain(written).collect();
    let mut inputs = files_of(Path::new(&arguments.model));
    inputs.push(script.to_owned());
    keep_inputs(&files, &inputs)?;
    let _outputs = Outputs::prepare(None, files)?;
    let instance = open_instance(arguments.validation, None)?;
    let adapter =
        pick_adapter(&instance, arguments.device.as_ref().unwrap_or(&DeviceChoice::Best))?;
    let device = open_device(&instance, &adapter)?;
    let Model { document, path } = model(arguments)?;
    let mut report = begin_report(&document, &adapter.name);
    let options = arguments.viewport_options(arguments.size);
    let mut session = WorkshopSession::new(&device, document, path, &options)?;
    report.transparency = session.transparency();
    let mut failed = Ok(());
    for ScriptLine { text, command } in &lines {
        match session.act(&command.from_origin(session.document.origin_m)) {
            Ok(outcome) => {
                if let Some(failure) = outcome.failure() {
                    ending.fail(format!("{text}: {failure}"));
                }
                if let CommandOutcome::Exported { left_out: Some(left_out), .. } = &outcome {
                    tracing::warn!("{text}: {left_out}");
                }
                report.steps.push(ScriptStep { command: text.clone(), outcome });
            }
            Err(error) => {
                let outcome = CommandOutcome::Failed(error.to_string());
                report.steps.push(ScriptStep { command: text.clone(), outcome });
                failed = Err(error);
                break;
            }
        }
    }
    drop(session);
    drop(device);
    report.validation_messages = instance.validation_log().len() as u64;
    if report.validation_messages > 0 {
        ending.fail(format!("{} messages of the validation layers", report.validation_messages));
    }
    write_report(arguments, &report, ending);
    failed
}

/// Returns the report of a model without commands.
pub(crate) fn begin_report(document: &Document, device: &str) -> ScriptReport {
    ScriptReport {
        version: REPORT_VERSION,
        model: document.scene.name.clone(),
        device: device.to_owned(),
        parts: document.scene.objects.len() as u64,
        triangles: document.scene.triangles(),
        steps: Vec::new(),
        transparency: None,
        validation_messages: 0,
    }
}

/// Writes a report to the file of the arguments, if there is one.
pub(crate) fn write_report(
    arguments: &WorkshopArguments,
    report: &ScriptReport,
    ending: &mut Ending,
) {
    let Some(file) = &arguments.report else { return };
    let Some(text) = ending.attempt(serde_json::to_vec_pretty(report)) else { return };
    if ending.attempt(write_file(file, &text)).is_some() {
        say_wrote(file);
    }
}

/// Generates or reads the model of the arguments.
pub(crate) fn model(arguments: &WorkshopArguments) -> Result<Model, RunError> {
    match arguments.model.as_str() {
        "waffle" => {
            let made = scenes::waffle_maker();
            let lid = Lid { group: made.lid, hinge: made.hinge };
            let mut document = Document::new(made.scene, made.parts, Some(lid));
            let curved = made.knob.into_iter().map(|curved| CurvedPart { curved, levels: None });
            document.curved.extend(curved);
            Ok(Model { document, path: made.cameras })
        }
        "assembly" => {
            let parts = arguments.parts.unwrap_or(ASSEMBLY_PARTS);
            let made = scenes::assembly(parts, arguments.seed.unwrap_or(1))?;
            Ok(Model {
                document: Document::new(made.generated.scene, made.parts, None),
                path: Vec::new(),
            })
        }
        file if file.contains(['.', '/']) => {
            // Parts must stay whole: pieces would be picked, cut and moved apart individually.
            let options = LoadOptions {
                cut_above_triangles: None,
                place: ScenePlace::NearOrigin,
                ..LoadOptions::default()
            };
            let loaded =
                scene_file::load(Path::new(file), &options, &mut |_| ControlFlow::Continue(()))?;
            for note in &loaded.notes {
                tracing::warn!("{note}");
            }
            let posed = loaded.placements.iter().filter(|of| of.skinned_mesh.is_some()).count();
            if posed > 0 {
                tracing::warn!(
                    "{posed} parts are skinned or morphed: they are shown, measured and exported as their meshes are, in no pose"
                );
            }
            let parts = file_parts(&loaded);
            let bodies = file_bodies(&loaded);
            let mut document = Document::new(loaded.scene, parts, None);
            document.origin_m = loaded.origin_m;
            document.bodies = bodies;
            Ok(Model { document, path: Vec::new() })
        }
        other => Err(RunError::user(format!(
            "there is no model '{other}': waffle, assembly, or a file, whose name has a dot or a slash"
        ))),
    }
}

//! Writes a single large mesh as a binary STL file, a cave around the eye or a hilly plain, and a
//! path through it for `walkthrough`. It serves to measure the benefit of culling a mesh in pieces.
//!
//! ```sh
//! cargo run --release -p scenes --example cave -- 5000000 cave.stl cave.txt
//! cargo run --release -p scenes --example cave -- 5000000 plain.stl plain.txt plain
//! ```

use std::error::Error;
use std::fs::File;
use std::io::{BufWriter, Write};

use glam::Vec3;

/// Millimetres per metre: STL files are in millimetres.
const UNIT: f32 = 1000.0;

/// The number of frames of the path.
const FRAMES: u16 = 60;

fn main() -> Result<(), Box<dyn Error>> {
    let given: Vec<String> = std::env::args().skip(1).collect();
    let (triangles, mesh, path, is_plain) = match given.as_slice() {
        [triangles, mesh, path] => (triangles, mesh, path, false),
        [triangles, mesh, path, kind] if kind == "plain" => (triangles, mesh, path, true),
        _ => return Err("usage: cave TRIANGLES FILE.stl PATH.txt [plain]".into()),
    };
    let triangles: u32 = triangles.parse()?;
    // Twice as many columns as rows, and two triangles per square.
    let rows = (triangles / 4).isqrt().clamp(8, 1 << 14);
    let point = if is_plain { plain } else { cave };
    let mut file = BufWriter::new(File::create(mesh)?);
    let count = rows * (2 * rows) * 2;
    file.write_all(&[b' '; 80])?;
    file.write_all(&count.to_le_bytes())?;
    for row in 0..rows {
        for column in 0..2 * rows {
            let at = |row: u32, column: u32| {
                let across = (column % (2 * rows)) as f32 / (2 * rows) as f32;
                point(
                    row as f32 / rows as f32,
                    if is_plain { column as f32 / (2 * rows) as f32 } else { across },
                )
            };
            let a = at(row, column);
            let b = at(row, column + 1);
            let c = at(row + 1, column + 1);
            let d = at(row + 1, column);
            triangle(&mut file, [a, c, b])?;
            triangle(&mut file, [a, d, c])?;
        }
    }
    file.flush()?;
    let mut file = BufWriter::new(File::create(path)?);
    writeln!(file, "antumbra path 1")?;
    for frame in 0..FRAMES {
        let share = f32::from(frame) / f32::from(FRAMES);
        let (sin, cos) = (share * std::f32::consts::TAU).sin_cos();
        let (eye, forward) = if is_plain {
            ([2.0 * cos, 60.0, 2.0 * sin], [0.0, -1.0, 0.01])
        } else {
            ([3.0 * cos, 0.0, 3.0 * sin], [cos, 0.2 * sin, sin])
        };
        let up = if is_plain { [0.0, 0.0, 1.0] } else { [0.0, 1.0, 0.0] };
        let numbers: Vec<String> =
            [eye, forward, up].iter().flatten().map(f32::to_string).collect();
        writeln!(file, "{} {} 1.0471976 0.2", f32::from(frame) / 30.0, numbers.join(" "))?;
    }
    Ok(file.flush()?)
}

/// Returns a point of a hollow sphere of rock with pillars, seen from inside; the arguments are the
/// shares of its latitude and longitude.
fn cave(down: f32, around: f32) -> Vec3 {
    let (sin, cos) = (down * std::f32::consts::PI).sin_cos();
    let (aside, ahead) = (around * std::f32::consts::TAU).sin_cos();
    // The poles are exact.
    let sin = if down == 0.0 || down == 1.0 { 0.0 } else { sin };
    let direction = Vec3::new(sin * ahead, cos, sin * aside);
    let waves = Vec3::new(
        (direction.x * 23.0).sin(),
        (direction.y * 19.0).sin(),
        (direction.z * 21.0).sin(),
    );
    direction * (10.0 + 3.0 * waves.x * waves.y * waves.z + 0.05 * (direction.x * 300.0).sin())
}

/// Returns a point of hills that are seen from above, all in sight of the path.
fn plain(down: f32, along: f32) -> Vec3 {
    let x = (along - 0.5) * 100.0;
    let z = (down - 0.5) * 50.0;
    Vec3::new(x, 1.5 * (x * 0.31).sin() * (z * 0.37).cos(), z)
}

fn triangle(file: &mut impl Write, corners: [Vec3; 3]) -> std::io::Result<()> {
    file.write_all(&[0; 12])?;
    for part in corners.map(|corner| (corner * UNIT).to_array()).as_flattened() {
        file.write_all(&part.to_le_bytes())?;
    }
    file.write_all(&[0; 2])
}

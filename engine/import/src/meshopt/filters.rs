//! Filters that turn what was decompressed into numbers (`EXT_meshopt_compression`, appendix B).
//! What the specification leaves open gives some number, never a panic.

use std::f32::consts::FRAC_1_SQRT_2;

/// Octahedral unit vectors of four 8-bit numbers, the last of which stays.
pub(super) fn octahedral8(bytes: &mut [u8]) {
    for element in bytes.as_chunks_mut::<4>().0 {
        let signed = element.map(|byte| f32::from(byte as i8));
        let [x, y, z] =
            octahedral(signed[0], signed[1], signed[2]).map(|it| (it * 127.0).round() as i8 as u8);
        *element = [x, y, z, element[3]];
    }
}

/// Octahedral unit vectors of four 16-bit numbers, the last of which stays.
pub(super) fn octahedral16(bytes: &mut [u8]) {
    for element in bytes.as_chunks_mut::<8>().0 {
        let [x, y, one, w] = words(element);
        let [x, y, z] = octahedral(f32::from(x), f32::from(y), f32::from(one)).map(snorm);
        write(element, [x, y, z, w]);
    }
}

/// The unit vector of a place on an octahedron, `one` along its axes.
fn octahedral(x: f32, y: f32, one: f32) -> [f32; 3] {
    let (x, y) = (x / one, y / one);
    let z = 1.0 - x.abs() - y.abs();
    // The lower half is folded over the upper.
    let fold = z.min(0.0);
    let (x, y) = (x - fold.copysign(x), y - fold.copysign(y));
    let length = (x * x + y * y + z * z).sqrt();
    [x / length, y / length, z / length]
}

/// Unit quaternions of 16-bit numbers without their largest, whose place is in the last two bits.
pub(super) fn quaternion(bytes: &mut [u8]) {
    for element in bytes.as_chunks_mut::<8>().0 {
        let [x, y, z, last] = words(element);
        let one = f32::from(last | 3);
        let [x, y, z] = [x, y, z].map(|it| f32::from(it) / one * FRAC_1_SQRT_2);
        let largest = (1.0 - x * x - y * y - z * z).max(0.0).sqrt();
        let mut numbers = [snorm(largest), snorm(x), snorm(y), snorm(z)];
        numbers.rotate_right((last & 3) as usize);
        write(element, numbers);
    }
}

/// Floats of an 8-bit exponent and a 24-bit mantissa.
pub(super) fn exponential(bytes: &mut [u8]) {
    for element in bytes.as_chunks_mut::<4>().0 {
        let packed = i32::from_le_bytes(*element);
        let (exponent, mantissa) = (packed >> 24, packed << 8 >> 8);
        *element = ((f64::from(mantissa) * 2f64.powi(exponent)) as f32).to_le_bytes();
    }
}

fn snorm(value: f32) -> i16 {
    (value * 32767.0).round() as i16
}

fn words(bytes: &[u8; 8]) -> [i16; 4] {
    std::array::from_fn(|word| i16::from_le_bytes([bytes[2 * word], bytes[2 * word + 1]]))
}

fn write(bytes: &mut [u8; 8], words: [i16; 4]) {
    for (bytes, word) in bytes.as_chunks_mut::<2>().0.iter_mut().zip(words) {
        *bytes = word.to_le_bytes();
    }
}

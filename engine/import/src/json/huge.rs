//! Numbers that exceed 64-bit floats. JSON readers refuse a whole file because of one of them,
//! wherever it is.

use std::ops::Range;

/// The replacement of such a number. It is not longer than the shortest of them, and beyond 32-bit
/// floats, too.
const STAND_IN: &[u8] = b"1e300";

/// Returns true if an error is caused by such a number.
pub(super) fn is_cause(error: &serde_json::Error) -> bool {
    error.to_string().starts_with("number out of range")
}

/// Returns the JSON with each such number replaced by a number that exceeds only 32-bit floats;
/// `None` if there is no such number. All other text stays in place.
pub(super) fn bounded(json: &[u8]) -> Option<Vec<u8>> {
    let mut bounded: Option<Vec<u8>> = None;
    for number in numbers(json) {
        let text = json.get(number.clone()).unwrap_or_default();
        if text.len() < STAND_IN.len()
            || !serde_json::from_slice::<f64>(text).is_err_and(|error| is_cause(&error))
        {
            continue;
        }
        let whole = bounded.get_or_insert_with(|| json.to_vec());
        let sign = usize::from(text.first() == Some(&b'-'));
        let digits = whole.get_mut(number.start + sign..number.end).unwrap_or_default();
        digits.fill(b' ');
        for (to, from) in digits.iter_mut().zip(STAND_IN) {
            *to = *from;
        }
    }
    bounded
}

/// Returns all ranges outside of strings that may be numbers.
fn numbers(json: &[u8]) -> impl Iterator<Item = Range<usize>> {
    let mut at = 0;
    std::iter::from_fn(move || {
        while let Some(byte) = json.get(at) {
            let start = at;
            at += 1;
            match byte {
                b'"' => {
                    while let Some(byte) = json.get(at).filter(|byte| **byte != b'"') {
                        at += if *byte == b'\\' { 2 } else { 1 };
                    }
                    at += 1;
                }
                b'-' | b'0'..=b'9' => {
                    let rest = json.get(at..).unwrap_or_default().iter();
                    at += rest.take_while(|byte| is_of_number(**byte)).count();
                    return Some(start..at);
                }
                _ => {}
            }
        }
        None
    })
}

fn is_of_number(byte: u8) -> bool {
    byte.is_ascii_digit() || matches!(byte, b'+' | b'-' | b'.' | b'e' | b'E')
}

#[cfg(test)]
mod tests {
    use super::bounded;

    #[test]
    fn numbers_too_great_to_be_read_become_ones_that_can_be() {
        let of = |json: &str| {
            bounded(json.as_bytes()).map(|json| String::from_utf8(json).expect("text"))
        };
        assert_eq!(of("[2e308,-1E+999]").as_deref(), Some("[1e300,-1e300 ]"));
        let long = format!("{{\"a\": {}.5}}", "9".repeat(310));
        let value: serde_json::Value =
            serde_json::from_str(&of(&long).expect("changed")).expect("JSON");
        assert_eq!(value["a"], 1e300);
        for same in ["1e308", "[1e-999, 0.5]", r#"{"1e999": "\"1e999\\"}"#, "\"1e999", "", "\"\\"] {
            assert_eq!(of(same), None, "{same}");
        }
    }
}

//! Rewords the errors of the JSON reader in terms of glTF.

/// The most characters of a value that are shown.
const LONGEST: usize = 80;

/// The words for a required object.
const OBJECT: &str = "an object";

/// Returns the sentence for an error of a value: the requirement, and the value found.
pub(super) fn sentence(error: &str) -> String {
    if let Some(field) = error.strip_prefix("missing field `") {
        let field = field.split('`').next().unwrap_or_default();
        return format!("it has no {field}");
    }
    let rest = ["invalid type: ", "invalid value: ", "invalid length "]
        .iter()
        .find_map(|start| error.strip_prefix(start));
    let Some((found, wanted)) = rest.and_then(|rest| rest.rsplit_once(", expected ")) else {
        return "it has a form that glTF does not have".to_owned();
    };
    let demand = must_be(wanted);
    let is_length = error.starts_with("invalid length ");
    let found = if is_length && demand == OBJECT {
        // A list with fewer elements than the object has fields.
        "is a list".to_owned()
    } else if is_length {
        format!("has {found}")
    } else {
        format!("is {}", is(found))
    };
    // The JSON reader has escaped characters that cannot be shown.
    let found: String = found.chars().take(LONGEST).collect();
    format!("it must be {demand}, and {found}")
}

/// Returns the words for the required value.
fn must_be(wanted: &str) -> String {
    match wanted {
        "u8" | "u16" | "u32" | "u64" | "usize" => "a whole number from 0 on".to_owned(),
        "i8" | "i16" | "i32" | "i64" => "a whole number".to_owned(),
        "f32" | "f64" => "a number".to_owned(),
        "a string" | "str" | "string" | "semantic name" => "text".to_owned(),
        "a boolean" => "true or false".to_owned(),
        "a sequence" => "a list".to_owned(),
        "a map" => OBJECT.to_owned(),
        "index into child of root" => "the index of an element".to_owned(),
        _ if wanted.starts_with("struct ") || wanted.starts_with("any valid JSON") => {
            OBJECT.to_owned()
        }
        _ => {
            let choices =
                wanted.strip_prefix("any of: ").map(|choices| format!("one of {choices}"));
            let numbers = wanted.split_once("array of length ").map(|(_, count)| count);
            let numbers = numbers.map(|count| format!("a list of {count} numbers"));
            choices.or(numbers).unwrap_or_else(|| "of another form".to_owned())
        }
    }
}

/// Returns the words for the value found.
fn is(found: &str) -> String {
    match found {
        "null" | "unit value" => "null".to_owned(),
        "map" => "an object".to_owned(),
        "sequence" => "a list".to_owned(),
        _ => {
            let of = |kind: &str| found.strip_prefix(kind).map(|value| value.replace('`', ""));
            let number =
                of("integer ").or_else(|| of("floating point ")).or_else(|| of("boolean "));
            let text = || found.strip_prefix("string ").map(|text| format!("the text {text}"));
            number.or_else(text).unwrap_or_else(|| "something else".to_owned())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::sentence;

    #[test]
    fn errors_say_what_must_be_and_what_is() {
        for (error, expected) in [
            (
                "invalid value: integer `-3`, expected u64",
                "it must be a whole number from 0 on, and is -3",
            ),
            (
                "invalid type: string \"a\", expected f32",
                "it must be a number, and is the text \"a\"",
            ),
            ("invalid type: map, expected a sequence", "it must be a list, and is an object"),
            (
                "invalid length 1, expected an array of length 16",
                "it must be a list of 16 numbers, and has 1",
            ),
            (
                "invalid length 0, expected struct Primitive with 7 elements",
                "it must be an object, and is a list",
            ),
            ("missing field `primitives`", "it has no primitives"),
            (
                "invalid type: null, expected any of: [\"SCALAR\"]",
                "it must be one of [\"SCALAR\"], and is null",
            ),
            ("whatever", "it has a form that glTF does not have"),
        ] {
            assert_eq!(sentence(error), expected);
        }
        let long = format!("invalid type: string \"{}\", expected u32", "x".repeat(1000));
        assert!(sentence(&long).len() < 200);
    }
}

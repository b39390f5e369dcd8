//! Fixed transforms: `ImageToProbe` and others, from PLUS, JSON or numbers.

use std::path::Path;

use serde_json::Value;

use bonebeam_files::{Result, cannot_be_opened, file_error, input};

use crate::poses::Euler;
use crate::transforms::{IDENTITY, Matrix, check_last_row, name_parts};

/// Largest file, bytes.
const LARGEST: u64 = 16 << 20;
/// Name of numbers without a name.
const USUAL: &str = "ImageToProbe";

/// Named transforms.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Calibration {
    /// Matrices by their names, mm.
    pub transforms: Vec<(String, Matrix)>,
}

impl Calibration {
    /// Reads `[NAME=]NUMBERS`, or the name of a file.
    ///
    /// A file is a configuration of PLUS (`.xml`), JSON (`.json`: an object of matrices by their names, or one matrix)
    /// or text with numbers. Numbers are 16 or 12 of a matrix, rows first, or x, y, z in mm and three Euler angles in
    /// degrees. Numbers without a name are `ImageToProbe`.
    ///
    /// # Errors
    /// A file that cannot be read, or other text.
    pub fn of(text: &str, euler: Euler) -> Result<Self> {
        let (name, rest) = match text.split_once('=') {
            Some((name, rest)) if name_parts(name.trim()).is_some() => (name.trim(), rest),
            _ => (USUAL, text),
        };
        if let Some(numbers) = numbers(rest) {
            let matrix = matrix(&numbers, euler)
                .map_err(|e| bonebeam_files::Error::Usage(format!("--calibration {text} {e}")))?;
            return Ok(Self {
                transforms: vec![(name.into(), matrix)],
            });
        }
        let path = Path::new(rest);
        let bytes =
            input::read(path, LARGEST).map_err(|e| file_error(path, cannot_be_opened(&e)))?;
        let text = String::from_utf8(bytes).map_err(|_| file_error(path, "is not UTF-8"))?;
        Self::of_file(name, &text, euler).map_err(|e| file_error(path, e))
    }

    fn of_file(name: &str, text: &str, euler: Euler) -> std::result::Result<Self, String> {
        let beginning = text.trim_start_matches('\u{feff}').trim_start();
        let transforms = match beginning.chars().next() {
            Some('<') => of_xml(beginning)?,
            Some('{' | '[') => of_json(name, beginning, euler)?,
            _ => {
                let numbers =
                    numbers(text).ok_or("is no configuration of PLUS, no JSON and no numbers")?;
                vec![(name.into(), matrix(&numbers, euler)?)]
            }
        };
        match transforms.is_empty() {
            true => Err("has no transforms".into()),
            false => Ok(Self { transforms }),
        }
    }
}

/// The numbers of a text that has nothing else.
pub(crate) fn numbers(text: &str) -> Option<Vec<f64>> {
    let words = text.split([',', ';', ' ', '\t', '\n', '\r', '[', ']']);
    let numbers: Option<Vec<f64>> = words
        .filter(|word| !word.is_empty())
        .map(|word| word.parse().ok())
        .collect();
    numbers.filter(|numbers| !numbers.is_empty())
}

pub(crate) fn matrix(numbers: &[f64], euler: Euler) -> std::result::Result<Matrix, String> {
    if numbers.iter().any(|number| !number.is_finite()) {
        return Err("has a NaN or infinite number".into());
    }
    let mut matrix = IDENTITY;
    match *numbers {
        [x, y, z, a, b, c] => {
            matrix = euler.matrix([a, b, c].map(f64::to_radians));
            for (row, value) in matrix.iter_mut().zip([x, y, z]) {
                row[3] = value;
            }
        }
        _ if [12, 16].contains(&numbers.len()) => {
            for (row, values) in matrix.iter_mut().zip(numbers.chunks(4)) {
                row.copy_from_slice(values);
            }
        }
        _ => {
            return Err(format!(
                "has {} numbers; expected 16, 12 or 6",
                numbers.len()
            ));
        }
    }
    check_last_row(&matrix).map(|()| matrix)
}

/// PLUS's `<Transform From="Image" To="Probe" Matrix="…"/>`.
fn of_xml(text: &str) -> std::result::Result<Vec<(String, Matrix)>, String> {
    let document = roxmltree::Document::parse(text).map_err(|e| format!("is damaged: {e}"))?;
    let mut transforms = Vec::new();
    for element in document
        .descendants()
        .filter(|element| element.has_tag_name("Transform"))
    {
        let [from, to, values] = ["From", "To", "Matrix"].map(|name| element.attribute(name));
        let (Some(from), Some(to), Some(values)) = (from, to, values) else {
            continue;
        };
        let name = format!("{from}To{to}");
        let numbers = numbers(values).filter(|numbers| numbers.len() == 16);
        let numbers = numbers.ok_or_else(|| format!("has a {name} that is not 16 numbers"))?;
        let matrix = matrix(&numbers, Euler::default()).map_err(|e| format!("{e} in {name}"))?;
        transforms.push((name, matrix));
    }
    Ok(transforms)
}

fn of_json(
    name: &str,
    text: &str,
    euler: Euler,
) -> std::result::Result<Vec<(String, Matrix)>, String> {
    let value: Value = serde_json::from_str(text).map_err(|e| format!("is damaged: {e}"))?;
    let one = |name: &str, value: &Value| {
        let values = value.as_array().into_iter().flatten();
        let flat = values.flat_map(|value| {
            value
                .as_array()
                .map_or(std::slice::from_ref(value), Vec::as_slice)
        });
        let numbers: Option<Vec<f64>> = flat.map(Value::as_f64).collect();
        let numbers = numbers.ok_or_else(|| format!("has a {name} that is not numbers"))?;
        let matrix = matrix(&numbers, euler).map_err(|e| format!("{e} in {name}"))?;
        Ok((name.to_owned(), matrix))
    };
    match &value {
        Value::Object(values) => {
            let named = values.iter().filter(|(name, _)| name_parts(name).is_some());
            named.map(|(name, value)| one(name, value)).collect()
        }
        value => Ok(vec![one(name, value)?]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The layout of PLUS's configurations.
    const PLUS: &str = r#"<PlusConfiguration version="2.1">
  <CoordinateDefinitions>
    <Transform From="Image" To="Probe"
      Matrix="
        0.000796231 0.0854272 0.000850194 12.74
        -0.0853999 0.000772721 0.00233653 50.76
        0.00232863 -0.000871617 0.0853992 -0.5
        0 0 0 1"
      Error="0.554673" Date="120811_143450" />
    <Transform From="TransducerOriginPixel" To="Image" Matrix="1 0 0 314 0 1 0 4 0 0 1 0 0 0 0 1" />
  </CoordinateDefinitions>
</PlusConfiguration>"#;

    #[test]
    fn a_configuration_of_plus_json_and_numbers_are_the_same() {
        let of = |text: &str| {
            Calibration::of_file(USUAL, text, Euler::default())
                .unwrap()
                .transforms
        };
        let plus = of(PLUS);
        assert_eq!(plus[1].0, "TransducerOriginPixelToImage");
        assert_eq!(plus[1].1[0], [1.0, 0.0, 0.0, 314.0]);
        let rows = plus[0].1;
        let json = serde_json::to_string(&rows).unwrap();
        for text in [
            json.clone(),
            format!("{{\"ImageToProbe\": {json}, \"about\": 3}}"),
            format!("{rows:?}"),
        ] {
            assert_eq!(of(&text)[..], plus[..1], "{text}");
        }
        let text = format!("{rows:?}");
        let direct = Calibration::of(&text, Euler::default()).unwrap();
        assert_eq!(direct.transforms[..], plus[..1]);
        let named = Calibration::of("ImageToCT=1,2,3,0,0,90", Euler::default()).unwrap();
        let (name, matrix) = &named.transforms[0];
        assert_eq!(name, "ImageToCT");
        assert!((matrix[1][0] - 1.0).abs() < 1e-12 && matrix[2][3] == 3.0);
    }

    #[test]
    fn what_is_no_calibration_is_refused() {
        let of = |text: &str| {
            Calibration::of_file(USUAL, text, Euler::default())
                .map(|_| ())
                .unwrap_err()
        };
        for (text, words) in [
            ("words", "no numbers"),
            ("1 2 3", "3 numbers; expected 16, 12 or 6"),
            ("1 0 0 0 0 1 0 0 0 0 1 0 0 0 1 1", "last row"),
            ("1 0 0 0 0 1 0 0 0 0 nan 0", "NaN"),
            (
                "<a><Transform From='A' To='B' Matrix='1 2'/></a>",
                "AToB that is not 16 numbers",
            ),
            ("<a/>", "no transforms"),
            ("<a>", "damaged"),
            ("{\"a\":", "damaged"),
            ("{\"AToB\": \"x\"}", "0 numbers"),
        ] {
            assert!(of(text).contains(words), "{}", of(text));
        }
        let missing = Calibration::of("no-such-file.xml", Euler::default()).unwrap_err();
        assert!(missing.to_string().contains("no such file"), "{missing}");
    }
}

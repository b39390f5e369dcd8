//! Contents of OpenIGTLink's messages: pictures, transforms, points and lines.
//!
//! Positions are in mm, in RAS as 3D Slicer expects.

use std::collections::BTreeMap;

use ndarray::Array2;

use crate::calibration;
use crate::cloud::{CloudPoint, unit};
use crate::message::{Message, Numbers, padded};
use crate::pixels::{Element, grey};
use crate::poses::Euler;
use crate::sequence::Tracked;
use crate::transforms::{IDENTITY, Matrix, name_parts};

/// Bytes before the pixels.
const IMAGE: usize = 72;
/// Status of a transform without one.
const OK: &str = "OK";

/// A picture of a stream.
#[derive(Debug)]
pub struct Image {
    /// The message; its content has the pixels.
    pub message: Message,
    /// Columns and rows.
    pub sides: [usize; 2],
    /// From (column, row, 0, 1) to the frame of reference, RAS, mm.
    pub matrix: Matrix,
    /// Transforms in the message's metadata.
    pub transforms: BTreeMap<String, Tracked>,
    element: Element,
    big_endian: bool,
    components: usize,
}

impl Image {
    /// Reads the head of an IMAGE.
    ///
    /// The picture may lie in any two of the three axes.
    ///
    /// # Errors
    /// A volume, a part of a picture, an unknown type of pixels, or pixels of another size than claimed.
    pub fn of(message: Message) -> Result<Self, String> {
        let head = || {
            let mut numbers = Numbers(&message.content);
            let [_] = numbers.u16s()?;
            let [components, kind, order, space] = numbers.next()?;
            let size = numbers.u16s::<3>()?;
            let matrix = numbers.f32s::<12>()?;
            Some((
                components,
                kind,
                [order, space],
                size,
                matrix,
                numbers.u16s::<6>()?,
            ))
        };
        let (components, kind, [order, space], size, numbers, part) =
            head().ok_or("an IMAGE of fewer than 72 bytes")?;
        let element = match kind {
            2 => Element::I8,
            3 => Element::U8,
            4 => Element::I16,
            5 => Element::U16,
            6 => Element::I32,
            7 => Element::U32,
            10 => Element::F32,
            11 => Element::F64,
            _ => return Err(format!("an IMAGE of the scalar type {kind}")),
        };
        let components = usize::from(components);
        if ![1, 3, 4].contains(&components) || ![1, 2].contains(&order) || ![1, 2].contains(&space)
        {
            return Err(format!(
                "an IMAGE of {components} components, byte order {order}, coordinates {space}"
            ));
        }
        if part[..3] != [0; 3] || part[3..] != size {
            return Err("a part of an IMAGE".into());
        }
        let axes = match size {
            [_, _, 1] => [0, 1],
            [1, _, _] => [1, 2],
            [_, 1, _] => [0, 2],
            _ => return Err(format!("an IMAGE of {size:?} pixels; expected one slice")),
        };
        let sides = axes.map(|axis| usize::from(size[axis]));
        let held = message.content.len() - IMAGE;
        let claimed = sides[0] * sides[1] * components * element.size();
        if claimed != held || claimed == 0 {
            return Err(format!(
                "an IMAGE of {size:?} pixels in {held} bytes; expected {claimed}"
            ));
        }
        if numbers.iter().any(|number| !number.is_finite()) {
            return Err("an IMAGE whose matrix is not finite".into());
        }
        let sign = if space == 2 {
            [-1.0, -1.0, 1.0]
        } else {
            [1.0; 3]
        };
        let mut matrix = IDENTITY;
        let [across, down] = axes.map(|axis| 3 * axis);
        let middle = sides.map(|side| (side as f64 - 1.0) / 2.0);
        for (k, row) in matrix.iter_mut().take(3).enumerate() {
            let [x, y] = [numbers[across + k], numbers[down + k]];
            let at = numbers[9 + k] - middle[0] * x - middle[1] * y;
            *row = [x, y, 0.0, at].map(|value| sign[k] * value);
        }
        stand(&mut matrix);
        let transforms = transforms(&message.metadata);
        Ok(Self {
            message,
            sides,
            matrix,
            transforms,
            element,
            big_endian: order == 1,
            components,
        })
    }

    /// The grey levels, `[row, column]`.
    ///
    /// # Errors
    /// A NaN or infinite level.
    pub fn pixels(&self) -> Result<Array2<f32>, String> {
        let bytes = &self.message.content[IMAGE..];
        let [columns, rows] = self.sides;
        let size = self.element.size();
        let levels: Vec<f32> = match (self.element, self.components) {
            (Element::U8, 1) => bytes.iter().copied().map(f32::from).collect(),
            _ => {
                let pixels = bytes.chunks_exact(size * self.components);
                pixels
                    .map(|pixel| {
                        grey(self.components, |k| {
                            self.element.value(&pixel[k * size..], self.big_endian)
                        })
                    })
                    .collect()
            }
        };
        match levels.iter().all(|level| level.is_finite()) {
            true => Ok(Array2::from_shape_vec((rows, columns), levels).unwrap_or_default()),
            false => Err("an IMAGE with a NaN or infinite pixel".into()),
        }
    }
}

/// Makes the third column the unit normal of the first two.
fn stand(matrix: &mut Matrix) {
    let [x, y] = [0, 1].map(|column| [0, 1, 2].map(|row| matrix[row][column]));
    let normal =
        unit([0, 1, 2].map(|k| x[(k + 1) % 3] * y[(k + 2) % 3] - x[(k + 2) % 3] * y[(k + 1) % 3]));
    matrix
        .iter_mut()
        .zip(normal)
        .for_each(|(row, value)| row[2] = value);
}

/// PLUS's fields of a frame, such as `ProbeToTrackerTransform` and `ProbeToTrackerTransformStatus`.
fn transforms(metadata: &[(String, String)]) -> BTreeMap<String, Tracked> {
    let value = |key: &str| {
        metadata
            .iter()
            .find(|(own, _)| own == key)
            .map(|(_, value)| value.as_str())
    };
    let of = |(key, text): &(String, String)| {
        let name = key
            .strip_suffix("Transform")
            .filter(|name| name_parts(name).is_some())?;
        let matrix = calibration::numbers(text)
            .and_then(|numbers| calibration::matrix(&numbers, Euler::default()).ok());
        let status = value(&format!("{key}Status")).unwrap_or(OK).to_owned();
        Some((name.to_owned(), Tracked { matrix, status }))
    };
    metadata.iter().filter_map(of).collect()
}

/// The matrix of a TRANSFORM, with the status that PLUS gives in the metadata.
///
/// # Errors
/// Another size.
pub fn transform(message: &Message) -> Result<Tracked, String> {
    let numbers = Numbers(&message.content)
        .f32s::<12>()
        .filter(|_| message.content.len() == 48);
    let numbers = numbers.ok_or_else(|| {
        format!(
            "sent a TRANSFORM of {} bytes; expected 48",
            message.content.len()
        )
    })?;
    let mut matrix = IDENTITY;
    for (k, row) in matrix.iter_mut().take(3).enumerate() {
        *row = [0, 1, 2, 3].map(|column| numbers[3 * column + k]);
    }
    let status = message
        .metadata
        .iter()
        .find(|(key, _)| key == "TransformStatus");
    let status = status.map_or(OK, |(_, status)| status).to_owned();
    Ok(Tracked {
        matrix: Some(matrix),
        status,
    })
}

fn put(content: &mut Vec<u8>, values: impl IntoIterator<Item = f64>) {
    content.extend(
        values
            .into_iter()
            .flat_map(|value| (value as f32).to_be_bytes()),
    );
}

/// The content of an IMAGE of bytes: columns, rows, and components as fit.
pub fn image_content(pixels: &[u8], [columns, rows]: [usize; 2], pose: &Matrix) -> Vec<u8> {
    let components = pixels.len() / (columns * rows).max(1);
    let sides = [columns as u16, rows as u16, 1];
    let mut content = Vec::with_capacity(IMAGE + pixels.len());
    // Bytes, in RAS.
    content.extend([0, 1, components as u8, 3, 1, 1]);
    content.extend(sides.iter().flat_map(|side| side.to_be_bytes()));
    let mut pose = *pose;
    stand(&mut pose);
    let middle = crate::transforms::apply(
        &pose,
        [(columns as f64 - 1.0) / 2.0, (rows as f64 - 1.0) / 2.0, 0.0],
    );
    put(
        &mut content,
        (0..3)
            .flat_map(|column| [0, 1, 2].map(|row| pose[row][column]))
            .chain(middle),
    );
    content.extend(
        [0, 0, 0]
            .into_iter()
            .chain(sides)
            .flat_map(u16::to_be_bytes),
    );
    content.extend(pixels);
    content
}

/// The content of a POINT: the names are the confidence, the owner is the picture's device.
pub fn point_content(points: &[CloudPoint], owner: &str) -> Vec<u8> {
    let mut content = Vec::with_capacity(136 * points.len());
    for point in points {
        content.extend(padded::<64>(&format!("{:.2}", point.confidence)));
        content.extend(padded::<32>("bone"));
        content.extend([255, 170, 40, 255]);
        put(&mut content, point.position.into_iter().chain([0.0]));
        content.extend(padded::<20>(owner));
    }
    content
}

/// The content of a POLYDATA: a line for each piece, of `pieces` points, and the confidence of each point.
pub fn polydata_content(points: &[CloudPoint], pieces: &[usize]) -> Vec<u8> {
    let mut first = 0;
    // A piece of one point is a vertex.
    let [mut vertices, mut lines] = [(0, vec![]), (0, vec![])];
    for &piece in pieces {
        let (count, cells) = if piece > 1 { &mut lines } else { &mut vertices };
        *count += 1;
        cells.push(piece);
        cells.extend(first..first + piece);
        first += piece;
    }
    let mut content = Vec::new();
    let put_u32 = |content: &mut Vec<u8>, values: &[usize]| {
        content.extend(
            values
                .iter()
                .flat_map(|value| (*value as u32).to_be_bytes()),
        );
    };
    // Sizes are in bytes. No polygons, no strips, one attribute.
    let sizes = [vertices.0, 4 * vertices.1.len(), lines.0, 4 * lines.1.len()];
    put_u32(&mut content, &[points.len()]);
    put_u32(&mut content, &sizes);
    put_u32(&mut content, &[0, 0, 0, 0, 1]);
    put(&mut content, points.iter().flat_map(|point| point.position));
    put_u32(&mut content, &vertices.1);
    put_u32(&mut content, &lines.1);
    // Scalars of points, of one component; the name is padded to an even length.
    content.extend([0, 1]);
    put_u32(&mut content, &[points.len()]);
    content.extend(b"confidence\0\0");
    put(
        &mut content,
        points.iter().map(|point| point.confidence.into()),
    );
    content
}

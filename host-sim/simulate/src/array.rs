//! The linear array.

use std::ops::Range;

/// A linear array on z = 0, centred on x = 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Array {
    /// Number of elements.
    pub elements: usize,
    /// Distance between neighbouring elements, m.
    pub pitch: f64,
    /// Gap between neighbouring elements, m.
    pub kerf: f64,
}

impl Array {
    /// x of a position given in pitches from element 0, m.
    pub fn x(&self, position: f64) -> f64 {
        (position - (self.elements - 1) as f64 / 2.0) * self.pitch
    }

    /// x of every element's centre, m.
    pub fn element_x(&self) -> Vec<f64> {
        (0..self.elements).map(|m| self.x(m as f64)).collect()
    }

    /// Width of an element, m.
    pub fn element_width(&self) -> f64 {
        self.pitch - self.kerf
    }

    /// Elements that transmit a beam at `position` pitches from element 0.
    ///
    /// They are round(focus/(f-number·pitch)) consecutive ones, at least 1, the first at ⌈position − count/2⌉,
    /// limited to the array.
    pub fn transmit_elements(&self, position: f64, focus: f64, f_number: f64) -> Range<usize> {
        let count = (focus / (f_number * self.pitch)).round();
        let count = count.clamp(1.0, self.elements as f64);
        let first = (position - count / 2.0).ceil();
        let end = (first + count).min(self.elements as f64);
        first.max(0.0) as usize..end as usize
    }
}

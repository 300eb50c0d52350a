//! How large a part is across its axis.

use super::sheet::Printed;

/// The diameter of the tube that a part goes through along its axis \[m\]: its outer diameter, of one that is not round the
/// diagonal of width and height, of one that says both (a flange on a round body) the larger. `None` where neither is known.
///
/// ```
/// use gearwise::catalog::{Printed, across};
/// let mm = |value: f64| Some(Printed::exact(value));
/// assert_eq!(across(None, mm(30.0), mm(40.0)), mm(50.0));
/// assert_eq!(across(mm(42.0), mm(30.0), mm(40.0)), mm(50.0));
/// assert_eq!(across(mm(42.0), mm(30.0), None), mm(42.0));
/// ```
pub fn across(outer: Option<Printed>, width: Option<Printed>, height: Option<Printed>) -> Option<Printed> {
    let diagonal = width.zip(height).map(|(w, h)| {
        let value = w.value.hypot(h.value);
        let spread = w.value * w.tolerance.unwrap_or(0.0) + h.value * h.tolerance.unwrap_or(0.0);
        Printed { value, tolerance: w.tolerance.or(h.tolerance).map(|_| spread / value) }
    });
    match (outer, diagonal) {
        (Some(outer), Some(diagonal)) => Some(if diagonal.value > outer.value { diagonal } else { outer }),
        (outer, diagonal) => outer.or(diagonal),
    }
}

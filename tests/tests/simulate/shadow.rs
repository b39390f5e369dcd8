//! The shadow of bone.

use super::*;

#[test]
fn a_shadowed_scatterer_contributes_nothing() {
    let settings = small();
    for summation in [Summation::Direct, Summation::Cells] {
        let without = simulate(&settings, &bone_and_points(), summation);
        let mut phantom = bone_and_points();
        // Right behind the bone: the outermost elements at ±2.3 mm do not see it.
        phantom
            .scatterers
            .push(Scatterer::new([0.0, 0.0, 11.2e-3], 100.0));
        assert_eq!(
            simulate(&settings, &phantom, summation).samples,
            without.samples
        );
        phantom.bone = None;
        assert_ne!(
            simulate(&settings, &phantom, summation).samples,
            without.samples
        );
    }
}

#[test]
fn each_element_sees_past_the_edge_on_its_own() {
    // One element transmits; the scatterer behind the right edge is seen from the right only.
    let settings = changed(small(), |s| s.f_number = 1e4);
    let mut phantom = bone_and_points();
    phantom.scatterers = vec![Scatterer::new([1.15e-3, 0.0, 12.5e-3], 1.0)];
    let bone = phantom.bone.clone().unwrap();
    let data = simulate(&settings, &phantom, Summation::Direct);
    let seen = visible(&bone, &data.element_x, &[[1.15e-3, 12.5e-3]]);
    for (element, x) in data.element_x.iter().enumerate() {
        // The straight line passes the corners (1, 9) and (1, 11) mm on the right.
        let at = |z: f64| x + (1.15e-3 - x) * z / 12.5e-3;
        let expected = at(9e-3) > 1e-3 && at(11e-3) > 1e-3;
        assert_eq!(seen[element][0], expected, "element {element}");
        let echo = row(&data, element, element);
        assert_eq!(echo.iter().any(|&v| v != 0.0), expected);
    }
    assert!(!seen[0][0] && seen[15][0]);
}

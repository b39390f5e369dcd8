//! Scatterers and levels of bone in a volume.

use super::*;

#[test]
fn bones_of_a_volume_have_their_scatterers_and_their_outline() {
    for bone in [
        Bone::Vertebra {
            mesh: None,
            slice: -4e-3,
        },
        Bone::SpinousProcesses,
        Bone::Laminae,
        Bone::FacetJoint,
    ] {
        let (phantom, warnings) = bone.phantom(15e-3, 6e-3, None).unwrap();
        assert!(warnings.is_empty());
        let outline = phantom.bone.as_ref().expect("the plane cuts it");
        let all = &phantom.scatterers;
        assert!(
            phantom.on_bone == all.len() && all.len() > 50_000,
            "{bone:?}: {}",
            all.len()
        );
        assert!(all.iter().all(|s| s.y.abs() <= 3e-3 && s.z > 14.9e-3));
        // Scatterers in the plane are on the outline, up to the surface's bend within 0.01 mm.
        let plane = all.iter().filter(|s| s.y.abs() < 0.01e-3);
        for s in plane.step_by(29) {
            assert!(
                outline.signed_distance(s.x, s.z).abs() < 0.2e-3,
                "{bone:?} {s:?}"
            );
        }
        // Tissue stays outside the bone.
        let mut filled = phantom.clone();
        let block = Block {
            x: [-15e-3, 15e-3],
            thickness: 2e-6,
            z: [12e-3, 37e-3],
            density: 5e12,
            seed: 2,
        };
        block.fill(&mut filled, Layers::Uniform, &|| ()).unwrap();
        let tissue = &filled.scatterers[phantom.on_bone..];
        assert!(tissue.len() > 1000);
        for s in tissue {
            assert!(
                outline.signed_distance(s.x, s.z) < 0.15e-3,
                "{bone:?} {s:?}"
            );
        }
        assert!(tissue.iter().any(|s| s.z > 30e-3));
    }
}

#[test]
fn the_density_of_scatterers_on_bone_is_the_papers() {
    let (phantom, _) = Bone::Vertebra {
        mesh: None,
        slice: 0.0,
    }
    .phantom(15e-3, 6e-3, None)
    .unwrap();
    let surface = phantom.surface.as_ref().unwrap();
    let within = surface
        .corners()
        .filter(|t| t.iter().all(|v| v[1].abs() <= 2e-3 && v[0].abs() <= 20e-3));
    let area: f64 = within
        .map(|[a, b, c]| {
            let (p, q) = (
                [0, 1, 2].map(|k| b[k] - a[k]),
                [0, 1, 2].map(|k| c[k] - a[k]),
            );
            let n = [
                p[1] * q[2] - p[2] * q[1],
                p[2] * q[0] - p[0] * q[2],
                p[0] * q[1] - p[1] * q[0],
            ];
            0.5 * n.iter().map(|v| v * v).sum::<f64>().sqrt()
        })
        .sum();
    let count = phantom
        .scatterers
        .iter()
        .filter(|s| s.y.abs() <= 2e-3 && s.x.abs() <= 20e-3)
        .count();
    // Triangles across the rim are not counted: one of eleven rows of 0.35 mm at the most.
    let density = count as f64 / area * 1e-6;
    assert!((200.0..225.0).contains(&density), "{density} per mm²");
}

#[test]
fn levels_are_those_of_the_phantom() {
    let block = Block {
        x: [-20e-3, 20e-3],
        thickness: 2e-3,
        z: [1e-3, 46e-3],
        density: 20e9,
        seed: 1,
    };
    let phantom = DynamicRange::phantom(&block).unwrap();
    let mean = |x: [f64; 2], z: [f64; 2]| {
        let within = |s: &&Scatterer| (x[0]..x[1]).contains(&s.x) && (z[0]..z[1]).contains(&s.z);
        let found: Vec<f64> = phantom
            .scatterers
            .iter()
            .filter(within)
            .map(|s| s.amplitude)
            .collect();
        20.0 * (found.iter().sum::<f64>() / found.len() as f64).log10()
    };
    assert!((mean([3e-3, 4e-3], [12e-3, 15e-3]) + 20.0).abs() < 1e-9);
    assert!((mean([7e-3, 9e-3], [29e-3, 31e-3]) + 10.0).abs() < 1e-9);
    // 1 mm of the lateral gradient spans 1.4 dB.
    assert!((mean([-0.5e-3, 0.5e-3], [39e-3, 44e-3]) + 25.0).abs() < 0.3);
    assert!(mean([-4e-3, -2e-3], [18e-3, 20e-3]).is_nan());
    assert_eq!(DynamicRange::level(8e-3, 19e-3), -40.0);
}

#[test]
fn reverberation_shows_the_bone_at_twice_its_depth_and_clutter_in_its_shadow() {
    let settings = changed(pairs(), |s| {
        (s.depth_end, s.beams, s.first_beam) = (26e-3, 1, 8.0)
    });
    let mut phantom = point(settings.array().x(8.0), 0.0, 10.2e-3);
    phantom.surface = Some(plate());
    let silent = channel_data(&settings, &phantom, Summation::Cells, &|_| ());
    assert!(silent.is_err(), "behind the plate");
    phantom.clutter = phantom.scatterers.clone();
    let heard = simulate(&settings, &phantom, Summation::Cells);
    assert!(strength(&heard, 0, 8) > 0.0);
    phantom.clutter.clear();
    phantom.scatterers[0].z = 9.9e-3;
    phantom.on_bone = 1;
    phantom.reverberation = 0.25;
    let data = simulate(&settings, &phantom, Summation::Cells);
    let row = row_of(&data, 0, 8);
    let peak = |z: f64| {
        let n = ((2.0 * z / settings.c - data.t0[0]) * settings.fs).round() as usize;
        row.iter()
            .skip(n - 30)
            .take(60)
            .fold(0.0f32, |m, v| m.max(v.abs()))
    };
    // A quarter by the reverberation, and a quarter again by the distance.
    let ratio = f64::from(peak(19.8e-3) / peak(9.9e-3));
    assert!((ratio * 16.0 - 1.0).abs() < 0.02, "{ratio}");
}

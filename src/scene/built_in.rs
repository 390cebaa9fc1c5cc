//! The built-in scenes: those of Palmer, Aktulga and Gao (2026), in a size for a desktop computer and in the paper's
//! size, and one for each further kind of drive.

/// A built-in scene.
#[derive(Clone, Copy, Debug)]
pub struct BuiltIn {
    /// Its name, which equals the `name` in its text.
    pub name: &'static str,
    /// One line: what it shows, and its size.
    pub summary: &'static str,
    /// Its JSON text.
    pub text: &'static str,
}

macro_rules! scenes {
    ($($name:literal: $summary:literal,)*) => {
        &[$(BuiltIn {
            name: $name,
            summary: $summary,
            text: include_str!(concat!("../../assets/", $name, ".json")),
        }),*]
    };
}

impl BuiltIn {
    /// The built-in scenes, in the order of lists.
    ///
    /// ```
    /// use relcp::{Scene, scene::BuiltIn};
    /// for scene in BuiltIn::ALL {
    ///     Scene::parse(scene.text, scene.name)?;
    /// }
    /// # Ok::<(), relcp::Error>(())
    /// ```
    pub const ALL: &'static [BuiltIn] = scenes! {
        "two-ellipsoids": "two ellipsoids are pushed together, slide and turn past each other (dt 0.01)",
        "two-ellipsoids-full": "the same at the step size of the paper's reference solution (dt 1e-5, 4,000,000 steps)",
        "three-capsules": "three spherocylinders that overlap at the start (8 steps; the paper's only size)",
        "compaction": "1,000 ellipsoids at 0.25 % volume fraction are drawn into a dense ball",
        "compaction-full": "10,000 ellipsoids, the paper's size",
        "colony": "one growing cell becomes a planar colony of 512",
        "colony-full": "one growing cell becomes 131,072, the paper's size",
        "chainmail": "a sheet of 6 x 6 interlaced rings is stretched until it is taut",
        "chainmail-full": "a sheet of 20 x 20 interlaced rings",
        "active-nematic": "320 rods that propel themselves in a disc gather along its wall",
        "sedimentation": "200 Brownian ellipsoids settle on the floor of a periodic cell",
        "two-strains": "two strains of cells compete in a channel whose open end they leave by",
        "filament": "a chain of 24 rods turns into a shear flow",
        "piston": "a moving wall compresses 130 rods",
        "swarm": "200 rods swim among 16 posts in a periodic plane",
        "pile": "120 rough ellipsoids fall onto a floor and come to rest in a pile",
        "mother-machine": "cells in eight trenches, whose offspring leave by a channel",
        "drum": "a turning drum takes ellipsoids and balls up its wall by friction",
        "ladder": "two rods lean on a wall: the steep one stands, the other slides down",
        "silo": "rough ellipsoids and balls leave a hopper through its outlet",
        "rough-channel": "rods with friction grow and divide in a channel that is open at both ends",
        "chaining": "cells that stay bonded after division fold into a crowd of chains in a channel",
        "dice": "dice, tablets and bricks, superellipsoids with friction, are poured into a tube",
        "biofilm": "cells on a floor grow by a nutrient from above: what grows ahead starves the rest",
        "pressed-ring": "a stiff ring of 32 rods is pressed flat by a moving wall",
        "mother-machine-array": "cells in four rows of trenches on two feeding channels grow by what diffuses in",
        "bidisperse-packing": "a loaded piston compresses balls of two sizes until they are jammed",
        "shear-cell": "rough ellipsoids and balls are sheared between two walls, one of them under a constant load",
    };

    /// The built-in scene of this name.
    pub fn named(name: &str) -> Option<&'static BuiltIn> {
        BuiltIn::ALL.iter().find(|scene| scene.name == name)
    }
}

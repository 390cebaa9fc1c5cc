//! What figures call a column: the name of its panel with its unit, and its own name at the end of its curve.

/// Exponents of length, time and force, and of a section: an area in space, a length in the plane.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Unit(pub [i32; 4]);

const NUMBER: Unit = Unit([0, 0, 0, 0]);
const LENGTH: Unit = Unit([1, 0, 0, 0]);
const AREA: Unit = Unit([2, 0, 0, 0]);
const PER_LENGTH: Unit = Unit([-1, 0, 0, 0]);
const TIME: Unit = Unit([0, 1, 0, 0]);
const PER_TIME: Unit = Unit([0, -1, 0, 0]);
const SPEED: Unit = Unit([1, -1, 0, 0]);
const FORCE: Unit = Unit([0, 0, 1, 0]);
const ENERGY: Unit = Unit([1, 0, 1, 0]);
const POWER: Unit = Unit([1, -1, 1, 0]);
const PRESSURE: Unit = Unit([0, 0, 1, -1]);
const VISCOSITY: Unit = Unit([0, 1, 1, -1]);

/// The name of a quantity and its unit.
pub(super) type Quantity = (&'static str, Unit);

/// Time, which figures over time have across.
pub(super) const OVER_TIME: Quantity = ("Time", NUMBER);

/// Of a column that is drawn over time: its panel, and its own name where the panel has several.
type OfColumn = (&'static str, Quantity, &'static str);

const COLUMNS: &[OfColumn] = &[
    ("bond_tension_mean", ("Tension of a bond", FORCE), "mean"),
    ("bond_tension_most", ("Tension of a bond", FORCE), "largest"),
    ("bending_energy", ("Bending energy", ENERGY), ""),
    ("contour_length", ("Length of a chain", LENGTH), "contour"),
    ("end_to_end", ("Length of a chain", LENGTH), "end to end"),
    ("persistence_length", ("Length of a chain", LENGTH), "persistence"),
    ("touching_per_body", ("Neighbours of a body", NUMBER), "touching"),
    ("pushing_per_body", ("Neighbours of a body", NUMBER), "pushing"),
    ("correlation_length", ("Orientational correlation length", LENGTH), ""),
    ("friction_mobilised", ("Share of contacts and of their friction", NUMBER), "mobilised"),
    ("friction_sliding", ("Share of contacts and of their friction", NUMBER), "sliding"),
    ("friction_force_mean", ("Friction of a contact", FORCE), "mean"),
    ("friction_force_most", ("Friction of a contact", FORCE), "largest"),
    ("chain_mean", ("Bodies in a force chain", NUMBER), "mean"),
    ("chain_largest", ("Bodies in a force chain", NUMBER), "largest"),
    ("group_1", ("Bodies of a group", NUMBER), "1"),
    ("group_2", ("Bodies of a group", NUMBER), "2"),
    ("group_3", ("Bodies of a group", NUMBER), "3"),
    ("group_4", ("Bodies of a group", NUMBER), "4"),
    ("group_largest", ("Bodies in a group", NUMBER), "largest"),
    ("group_smallest", ("Bodies in a group", NUMBER), "smallest"),
    ("group_diversity", ("Simpson's diversity of groups", NUMBER), ""),
    ("length_mean", ("Length of a rod", LENGTH), "mean"),
    ("length_least", ("Length of a rod", LENGTH), "shortest"),
    ("length_most", ("Length of a rod", LENGTH), "longest"),
    ("domains", ("Number of microdomains", NUMBER), ""),
    ("domain_mean", ("Bodies in a microdomain", NUMBER), "mean"),
    ("domain_largest", ("Bodies in a microdomain", NUMBER), "largest"),
    ("msd", ("Mean squared displacement", AREA), ""),
    ("msr", ("Mean squared rotation in square radians", NUMBER), ""),
    ("nematic_order", ("Nematic order", NUMBER), "global"),
    ("nematic_local", ("Nematic order", NUMBER), "local"),
    ("packing_hull", ("Packing fraction", NUMBER), "hull"),
    ("packing_core", ("Packing fraction", NUMBER), "core"),
    ("packing_walls", ("Packing fraction inside of walls", NUMBER), ""),
    ("radius_gyration", ("Radius", LENGTH), "gyration"),
    ("radius_outermost", ("Radius", LENGTH), "outermost"),
    ("expansion_rate", ("Expansion rate", SPEED), ""),
    ("removed", ("Bodies removed since the start", NUMBER), ""),
    ("removal_rate", ("Bodies removed", PER_TIME), ""),
    ("segregation", ("Contacts within groups over a random mixture's", NUMBER), ""),
    ("assortativity", ("Assortativity of groups", NUMBER), ""),
    ("shear_stress", ("Shear stress", PRESSURE), ""),
    ("shear_viscosity", ("Contact viscosity", VISCOSITY), ""),
    ("normal_difference_1", ("Normal stress difference", PRESSURE), "first"),
    ("normal_difference_2", ("Normal stress difference", PRESSURE), "second"),
    ("shear_power", ("Power", POWER), "shear"),
    ("shear_dissipation", ("Power", POWER), "drag"),
    ("dissipation", ("Power that drag takes", POWER), ""),
    ("velocity_correlation_length", ("Velocity correlation length", LENGTH), ""),
    ("velocity_order", ("Polar order of the velocities", NUMBER), ""),
    ("speed_mean", ("Mean speed", SPEED), ""),
    ("pressure", ("Contact stress", PRESSURE), "pressure"),
    ("shear", ("Contact stress", PRESSURE), "shear"),
    ("force_mean", ("Force of a contact", FORCE), "mean"),
    ("force_most", ("Force of a contact", FORCE), "largest"),
    ("wall_force", ("Normal force on walls", FORCE), "all walls"),
    ("wall_force_most", ("Normal force on walls", FORCE), "largest wall"),
    ("wall_pressure", ("Pressure on walls", PRESSURE), ""),
    ("field_mean", ("Concentration of the field", NUMBER), "mean"),
    ("field_least", ("Concentration of the field", NUMBER), "least"),
    ("field_most", ("Concentration of the field", NUMBER), "largest"),
    ("field_amount", ("Amount in the field", NUMBER), ""),
];

/// Of a profile: what it has across, and what up.
const PROFILES: [(&str, Quantity, Quantity); 14] = [
    ("bonds", ("Links along the chain", NUMBER), ("Mean cosine between directions", NUMBER)),
    ("contacts", ("Neighbours that a body touches", NUMBER), ("Bodies", NUMBER)),
    ("correlation", ("Distance", LENGTH), ("Orientational correlation", NUMBER)),
    ("density", ("Distance from the centre", LENGTH), ("Filled fraction", NUMBER)),
    ("fields", ("Field", NUMBER), ("Mean concentration", NUMBER)),
    ("force_chains", ("Bodies in the force chain", NUMBER), ("Force chains", NUMBER)),
    ("groups", ("Group", NUMBER), ("Bodies", NUMBER)),
    ("length", ("Length of a rod", LENGTH), ("Probability density", PER_LENGTH)),
    ("microdomains", ("Bodies in the microdomain", NUMBER), ("Microdomains", NUMBER)),
    ("msd", ("Lag", TIME), ("Mean squared displacement", AREA)),
    ("removal", ("Rule", NUMBER), ("Bodies removed since the start", NUMBER)),
    ("stress", ("Distance from the centre", LENGTH), ("Contact pressure", PRESSURE)),
    ("velocity_correlation", ("Distance", LENGTH), ("Correlation of directions of velocity", NUMBER)),
    ("walls", ("Wall", NUMBER), ("Normal force", FORCE)),
];

/// The words of a column that is drawn over time; its own name where there are none.
pub(super) fn of_column(name: &'static str) -> (Quantity, &'static str) {
    let known = COLUMNS.iter().find(|(own, ..)| *own == name);
    known.map_or(((name, NUMBER), name), |(_, panel, end)| (*panel, *end))
}

/// What the profile of a measure has across and up.
pub(super) fn of_profile(measure: &'static str) -> [Quantity; 2] {
    let known = PROFILES.iter().find(|(own, ..)| *own == measure);
    known.map_or([("", NUMBER), (measure, NUMBER)], |(_, x, y)| [*x, *y])
}

/// A quantity with its unit, in thousands of it where `power` is 3, and so on.
pub(super) fn named((name, unit): Quantity, power: i32, planar: bool) -> String {
    let unit = in_words(unit, planar);
    let scale = match power {
        0 => String::new(),
        _ => format!("10{}", power.to_string().chars().map(raised).collect::<String>()),
    };
    match (scale.is_empty(), unit.is_empty()) {
        (true, true) => name.into(),
        (false, true) => format!("{name} ({scale})"),
        (true, false) => format!("{name} ({unit})"),
        (false, false) => format!("{name} ({scale} {unit})"),
    }
}

fn in_words(Unit([length, time, force, section]): Unit, planar: bool) -> String {
    let length = length + section * if planar { 1 } else { 2 };
    let powers = [("force", force), ("length", length), ("time", time)];
    let words = |sign: i32| {
        let of = |(name, power): &(&str, i32)| match (*name, power * sign) {
            ("length", 2) => "area".to_owned(),
            (name, 1) => name.to_owned(),
            (name, power) => format!("{name}{}", power.to_string().chars().map(raised).collect::<String>()),
        };
        powers.iter().filter(|(_, power)| power * sign > 0).map(of).collect::<Vec<_>>().join(" × ")
    };
    let (over, under) = (words(1), words(-1));
    match (over.is_empty(), under.is_empty()) {
        (_, true) => over,
        (true, false) => format!("per {under}"),
        (false, false) => format!("{over} per {under}"),
    }
}

fn raised(digit: char) -> char {
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    digit.to_digit(10).and_then(|digit| DIGITS.get(digit as usize).copied()).unwrap_or('⁻')
}

#[cfg(test)]
mod tests {
    use super::super::super::ALL;
    use super::*;

    #[test]
    fn every_column_that_is_drawn_has_words_and_a_panel_has_one_unit() {
        let mut columns = 0;
        for measure in ALL {
            for panel in measure.about().plots {
                let words: Vec<_> = panel.iter().map(|column| of_column(column)).collect();
                assert!(words.iter().all(|(quantity, _)| *quantity == words[0].0), "{panel:?}");
                let known = |name: &&str| COLUMNS.iter().any(|(own, ..)| own == name);
                assert!(panel.iter().all(known), "{panel:?}");
                // Curves of one panel have different names.
                let mut ends: Vec<_> = words.iter().map(|(_, end)| *end).collect();
                ends.sort_unstable();
                ends.dedup();
                assert!(ends.len() == panel.len() && (panel.len() == 1 || !ends.contains(&"")), "{panel:?}");
                columns += panel.len();
            }
            assert_eq!(measure.profile().is_some(), PROFILES.iter().any(|(own, ..)| *own == measure.name()));
        }
        assert_eq!(columns, COLUMNS.len());
    }

    #[test]
    fn units_are_words_of_the_scene_and_powers_of_ten() {
        let stress = ("Stress", PRESSURE);
        assert_eq!(named(stress, 0, false), "Stress (force per area)");
        assert_eq!(named(stress, -6, true), "Stress (10⁻⁶ force per length)");
        assert_eq!(named(("Viscosity", VISCOSITY), 0, false), "Viscosity (force × time per area)");
        assert_eq!(named(("Rate", PER_TIME), 0, true), "Rate (per time)");
        assert_eq!(
            (named(("Order", NUMBER), 0, true), named(("Order", NUMBER), 6, true)),
            ("Order".into(), "Order (10⁶)".into())
        );
    }
}

//! Bars: of kinds by name, with their values at their ends, and of numbers by size, a panel for each of a few states.

use super::super::{Cell, Frame};
use super::words::{Quantity, named};
use crate::figure::Figure;
use crate::figure::drawing::{self, AXIS, Area, COLOURS, COLUMN, Failed, MARGIN, POINT, TEXT, X_LABELS};
use crate::page::width_of;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// The most kinds that have a bar of their own; those with the least values are one beyond.
const MOST_KINDS: usize = 24;
/// From a bar of a kind to the next, and the part of it that the bar takes.
const ROW: u32 = TEXT * 5 / 4;
const THICK: f64 = 0.7;
/// The most room for names of kinds.
const NAMES: u32 = COLUMN * POINT / 2;
/// The height of a panel of bars by size, with the row of its name.
const PANEL: u32 = 72 * POINT;
/// Sizes up to this have a bar each; beyond, a bar is for sizes from a power of two to the next.
const SINGLE_SIZES: usize = 16;

fn style(across: HPos, up: VPos) -> TextStyle<'static> {
    ("sans-serif", TEXT).into_font().color(&BLACK).pos(Pos::new(across, up))
}

/// What follows the name of a wall, of its first surface.
pub(super) const FIRST_FACE: &str = ", face 0";

/// What the kind of a profile's row is called.
pub(super) fn kind(frame: &Frame, measure: &str, row: &[Cell]) -> String {
    let number = |column: usize| row.get(column).copied().flatten().unwrap_or(0.0) as usize;
    match measure {
        "groups" if number(0) == 0 => "no group".into(),
        "groups" => frame.group_names.get(number(0) - 1).cloned().unwrap_or_else(|| format!("group {}", number(0))),
        "walls" => format!("wall {}, face {}", number(2), number(3)),
        "removal" => format!("rule {}", number(0)),
        _ => number(0).to_string(),
    }
}

/// A bar for each kind, one below the other; `name` says what they are the numbers of.
pub(super) fn of_kinds(title: &str, name: &str, kinds: Vec<(String, f64)>) -> Result<Figure, Failed> {
    let kinds = the_largest(kinds);
    let top = TEXT * 3 / 2;
    let high = (top + ROW * kinds.len() as u32 + MARGIN).div_ceil(POINT);
    let values: Vec<String> = kinds.iter().map(|(_, value)| drawing::shortest(*value, 4)).collect();
    let widest = |texts: &mut dyn Iterator<Item = &String>| {
        texts.map(|text| width_of(text, TEXT as f32).ceil() as u32).max().unwrap_or(0)
    };
    let left = (MARGIN + widest(&mut kinds.iter().map(|(kind, _)| kind)).min(NAMES) + MARGIN) as i32;
    let right = (COLUMN * POINT).saturating_sub(MARGIN * 2 + widest(&mut values.iter())) as i32;
    let most = kinds.iter().map(|(_, value)| *value).fold(0.0, f64::max);
    drawing::draw(title, [COLUMN, high], |page| {
        page.draw(&Text::new(name.to_owned(), (MARGIN as i32, top as i32 / 2), style(HPos::Left, VPos::Center)))?;
        for (k, ((kind, value), shown)) in kinds.iter().zip(values).enumerate() {
            let middle = (top + ROW * k as u32 + ROW / 2) as i32;
            let half = (THICK * f64::from(ROW) / 2.0) as i32;
            let long = if most > 0.0 { (f64::from(right - left) * value.max(0.0) / most).round() as i32 } else { 0 };
            page.draw(&Text::new(kind.clone(), (left - MARGIN as i32, middle), style(HPos::Right, VPos::Center)))?;
            page.draw(&Rectangle::new([(left, middle - half), (left + long, middle + half)], COLOURS[0].filled()))?;
            page.draw(&Text::new(shown, (left + long + MARGIN as i32, middle), style(HPos::Left, VPos::Center)))?;
        }
        let line = [(left, top as i32), (left, (top + ROW * kinds.len() as u32) as i32)];
        page.draw(&PathElement::new(line, BLACK.stroke_width(AXIS)))?;
        Ok(())
    })
}

/// The kinds in their order, those with the least values as one where there are many.
fn the_largest(kinds: Vec<(String, f64)>) -> Vec<(String, f64)> {
    if kinds.len() <= MOST_KINDS {
        return kinds;
    }
    let mut order: Vec<usize> = (0..kinds.len()).collect();
    order.sort_by(|a, b| kinds[*b].1.total_cmp(&kinds[*a].1).then(a.cmp(b)));
    let mut kept = order[..MOST_KINDS - 1].to_vec();
    kept.sort_unstable();
    let others: f64 = order[MOST_KINDS - 1..].iter().map(|k| kinds[*k].1).sum();
    let rest = (format!("{} others", kinds.len() + 1 - MOST_KINDS), others);
    kept.into_iter().map(|k| kinds[k].clone()).chain([rest]).collect()
}

/// A panel for each state, which `states` has by name with its sizes and how many there are of each.
pub(super) fn of_sizes(
    title: &str,
    [across, up]: [Quantity; 2],
    states: &[(String, Vec<(f64, f64)>)],
) -> Result<Figure, Failed> {
    let sizes = || states.iter().flat_map(|(_, rows)| rows);
    let least = sizes().map(|(size, _)| *size as usize).min().unwrap_or(0);
    let most = sizes().map(|(size, _)| *size as usize).max().unwrap_or(0);
    let bins = bins(least, most);
    let high = (PANEL * states.len() as u32 + X_LABELS).div_ceil(POINT);
    drawing::draw(title, [COLUMN, high], |page| {
        let mut rest = page.clone();
        for (k, (state, rows)) in states.iter().enumerate() {
            let last = k + 1 == states.len();
            let (area, others) = rest.split_vertically(PANEL + if last { X_LABELS } else { 0 });
            let name = if k == 0 { format!("{}, {state}", named(up, 0, false)) } else { state.clone() };
            draw_panel(&area, &name, &bins, rows, last.then(|| named(across, 0, false)))?;
            rest = others;
        }
        Ok(())
    })
}

/// The least and the largest size of each bar.
fn bins(least: usize, most: usize) -> Vec<[usize; 2]> {
    if most <= SINGLE_SIZES {
        return (least..=most).map(|size| [size, size]).collect();
    }
    let mut bins = vec![[least.min(1); 2]];
    while bins[bins.len() - 1][1] < most {
        let from = bins[bins.len() - 1][1] + 1;
        bins.push([from, if from < 2 { from } else { 2 * from.next_power_of_two() - 1 }]);
    }
    bins
}

fn draw_panel(
    area: &Area<'_>,
    name: &str,
    bins: &[[usize; 2]],
    rows: &[(f64, f64)],
    across: Option<String>,
) -> Result<(), Failed> {
    let count = |[from, to]: &[usize; 2]| {
        let inside = |size: f64| (*from..=*to).contains(&(size as usize));
        rows.iter().filter(|(size, _)| inside(*size)).map(|(_, count)| count).sum::<f64>()
    };
    let counts: Vec<f64> = bins.iter().map(count).collect();
    let most = counts.iter().copied().fold(0.0, f64::max);
    let (wide, _) = area.dim_in_pixel();
    let (left, right) = (MARGIN as i32, (wide - MARGIN) as i32);
    // The name, then the number over the highest bar.
    let (top, floor) = (TEXT as i32 * 3, (PANEL - MARGIN) as i32);
    area.draw(&Text::new(name.to_owned(), (left, TEXT as i32 * 3 / 4), style(HPos::Left, VPos::Center)))?;
    let each = f64::from(right - left) / bins.len() as f64;
    let texts: Vec<String> = bins.iter().map(label).collect();
    let widest = texts.iter().map(|text| width_of(text, TEXT as f32)).fold(0.0, f32::max);
    // Every second or third has its size below it where all have no room.
    let named = (f64::from(widest + TEXT as f32 / 2.0) / each).ceil().max(1.0) as usize;
    for (k, (count, text)) in counts.iter().zip(texts).enumerate() {
        let middle = left + (each * (k as f64 + 0.5)) as i32;
        let half = (THICK * each / 2.0) as i32;
        let tall = if most > 0.0 { (f64::from(floor - top) * count / most).round() as i32 } else { 0 };
        area.draw(&Rectangle::new([(middle - half, floor - tall), (middle + half, floor)], COLOURS[0].filled()))?;
        let shown = drawing::shortest(*count, 4);
        if *count > 0.0 && f64::from(width_of(&shown, TEXT as f32)) < each * 1.2 {
            area.draw(&Text::new(shown, (middle, floor - tall - TEXT as i32 / 2), style(HPos::Center, VPos::Center)))?;
        }
        if across.is_some() && k % named == 0 {
            area.draw(&Text::new(text, (middle, floor + TEXT as i32 * 3 / 4), style(HPos::Center, VPos::Center)))?;
        }
    }
    area.draw(&PathElement::new([(left, floor), (right, floor)], BLACK.stroke_width(AXIS)))?;
    if let Some(across) = across {
        let place = ((left + right) / 2, floor + TEXT as i32 * 2);
        area.draw(&Text::new(across, place, style(HPos::Center, VPos::Center)))?;
    }
    Ok(())
}

fn label([from, to]: &[usize; 2]) -> String {
    if from == to { from.to_string() } else { format!("{from}–{to}") }
}

#[cfg(test)]
mod tests {
    use super::super::words;
    use super::*;

    #[test]
    fn bars_are_of_single_sizes_or_double() {
        assert_eq!(bins(0, 3), [[0, 0], [1, 1], [2, 2], [3, 3]]);
        assert_eq!(bins(1, 20), [[1, 1], [2, 3], [4, 7], [8, 15], [16, 31]]);
        assert_eq!(bins(0, 17)[..3], [[0, 0], [1, 1], [2, 3]]);
        // Every size is in one bar.
        for size in 1..300 {
            assert_eq!(bins(1, 299).iter().filter(|[from, to]| (*from..=*to).contains(&size)).count(), 1, "{size}");
        }
    }

    #[test]
    fn the_kinds_with_the_least_values_are_one() {
        let kinds: Vec<(String, f64)> = (0..44).map(|k| (format!("strain {k}"), f64::from((k * 7) % 44))).collect();
        let all: f64 = kinds.iter().map(|(_, value)| value).sum();
        let found = the_largest(kinds.clone());
        assert_eq!((found.len(), found[23].0.as_str()), (24, "21 others"));
        assert_eq!(found.iter().map(|(_, value)| value).sum::<f64>(), all);
        assert!(
            found[..23].iter().all(|(_, value)| *value >= 21.0) && found[..23].windows(2).all(|w| w[0].0 != w[1].0)
        );
        let svg = of_kinds("groups_profile", "Bodies, t = 1", kinds).unwrap().svg();
        assert!(svg.contains(">strain 6<") && svg.contains(">21 others<") && svg.contains(">Bodies, t = 1<"), "{svg}");
        // The background, and a bar for each.
        assert_eq!(svg.matches("fill=\"#0072b2\"").count(), 24, "{svg}");
    }

    #[test]
    fn states_have_a_panel_each_and_the_same_bars() {
        let states =
            [("t = 1".to_owned(), vec![(1.0, 4.0), (3.0, 2.0)]), ("t = 2".to_owned(), vec![(2.0, 8.0), (40.0, 1.0)])];
        let svg = of_sizes("microdomains_profile", words::of_profile("microdomains"), &states).unwrap().svg();
        for text in [">Microdomains, t = 1<", ">t = 2<", ">32–63<", ">2–3<", ">Bodies in the microdomain<"] {
            assert_eq!(svg.matches(text).count(), 1, "{text}: {svg}");
        }
        assert_eq!((svg.matches(">8<").count(), svg.matches(">2<").count()), (1, 1), "{svg}");
    }
}

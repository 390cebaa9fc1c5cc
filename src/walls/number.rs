//! The numbers of surfaces where a pair has its second body. All begin with `FIRST`, so that the numbers do not change
//! as bodies divide:
//!
//! * what a step remembers of pairs, and files, have [`number_of`] a surface, and the place of the body as a feature;
//! * lists of pairs on a device have one number for both ([`AtSurface`]): that of the place among all places;
//! * rows on the CPU count on from the bodies ([`in_rows`]), because a solver indexes bodies by them.

/// The number of the first surface. No scene has as many bodies ([`crate::scene::MAX_BODIES`]).
const FIRST: u32 = 1 << 31;

/// Which surface a number in the place of a body's means; `None` for a body.
#[inline]
pub fn surface_of(number: u32) -> Option<usize> {
    number.checked_sub(FIRST).map(|surface| surface as usize)
}

/// The number of a surface in the place of a body's.
#[inline]
pub fn number_of(surface: usize) -> u32 {
    FIRST + surface as u32
}

/// A body's number, or that of a surface, as rows of so many bodies have it.
#[inline]
pub(crate) fn in_rows(number: u32, bodies: usize) -> u32 {
    surface_of(number).map_or(number, |surface| (bodies + surface) as u32)
}

/// The number of a body or a surface of rows of so many bodies: the inverse of [`in_rows`].
#[inline]
pub(crate) fn of_rows(place: u32, bodies: usize) -> u32 {
    (place as usize).checked_sub(bodies).map_or(place, number_of)
}

/// A surface, and which place of a body meets it.
#[cfg(feature = "gpu")]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct AtSurface {
    pub surface: usize,
    pub place: u32,
}

#[cfg(feature = "gpu")]
impl AtSurface {
    /// Places of a body at one surface at most.
    pub const PLACES: u32 = 4;

    /// The first number, as kernels need it.
    pub const FIRST: u32 = FIRST;

    /// The number of the place among those of all surfaces.
    pub fn number(self) -> u32 {
        number_of(Self::PLACES as usize * self.surface + self.place as usize)
    }

    /// The place of this number; `None` for a body.
    pub fn of_number(number: u32) -> Option<Self> {
        let place = surface_of(number)? as u32;
        Some(AtSurface { surface: (place / Self::PLACES) as usize, place: place % Self::PLACES })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_rows_are_those_of_bodies_and_surfaces() {
        for (number, place) in [(0, 0), (6, 6), (number_of(0), 7), (number_of(5), 12)] {
            assert_eq!((in_rows(number, 7), of_rows(place, 7)), (place, number));
        }
    }

    #[cfg(feature = "gpu")]
    #[test]
    fn numbers_of_places_hold_the_surface_and_the_place() {
        let mut last = 6;
        for (surface, place) in (0..3).flat_map(|surface| (0..AtSurface::PLACES).map(move |place| (surface, place))) {
            let at = AtSurface { surface, place };
            assert!(at.number() > last && surface_of(at.number()).is_some());
            assert_eq!(AtSurface::of_number(at.number()), Some(at));
            last = at.number();
        }
        assert_eq!(AtSurface::of_number(6), None);
    }
}

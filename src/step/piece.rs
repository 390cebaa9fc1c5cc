//! The piece of a step that is taken at once: the whole step, or after a failure a part of it, in which some cells may
//! have to wait.

/// A piece of a step, in parts of the step. Pieces come from halving, so that their numbers are exact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    /// Where in the step it begins.
    pub start: f64,
    /// How long it is.
    pub length: f64,
    /// How long the step is, in parts of `dt`: 1, but for a run's last step, which may be shorter.
    pub span: f64,
    /// How far daughters that are born in it turn, in parts of what they drew: 1, but where there is no room to turn.
    pub turn: f64,
}

impl Piece {
    /// The step in one.
    pub const WHOLE: Piece = Piece::whole(1.0);

    /// A step of this part of `dt` in one.
    pub const fn whole(span: f64) -> Piece {
        Piece { start: 0.0, length: 1.0, span, turn: 1.0 }
    }

    /// Whether it is a step in one.
    pub fn is_whole(self) -> bool {
        self.length == 1.0
    }

    /// The shortest piece, a 64th: after it a step counts as one that cannot be taken. Six halvings make a way that
    /// leads through a body of the usual steps (under 48 thicknesses a step) one that does not, and contradictions
    /// between rows 64 to 4,096 times smaller.
    pub const SHORTEST: f64 = 1.0 / 64.0;

    /// Whether it has no halves.
    pub fn is_shortest(self) -> bool {
        self.length <= Piece::SHORTEST
    }

    /// The same, in which daughters turn by this part of what they drew.
    pub fn turning(self, turn: f64) -> Piece {
        Piece { turn, ..self }
    }

    /// Its two halves; none of the shortest piece.
    pub fn halves(self) -> Option<[Piece; 2]> {
        let length = 0.5 * self.length;
        let half = |start| Piece { start, length, ..self };
        (length >= Piece::SHORTEST).then(|| [half(self.start), half(self.start + length)])
    }

    /// Whether the step is over after it.
    pub fn ends_step(self) -> bool {
        self.start + self.length >= 1.0
    }
}

/// Which cells [`crowded`](super::RetryBackend::crowded) names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Crowd {
    /// Those of the wedge: see [`RetryBackend::wedge`](super::RetryBackend::wedge).
    Wedged,
    /// Those that overlap by more than the tolerance at the trial.
    Overlapping,
    /// Those on which a contact force acts.
    Pressed,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_of_halves_fill_the_step_exactly_down_to_a_64th() {
        let mut pieces = vec![Piece::WHOLE];
        while let Some(halves) = pieces.iter().map(|piece| piece.halves()).collect::<Option<Vec<_>>>() {
            pieces = halves.concat();
        }
        assert_eq!(pieces.len(), 64);
        let mut at = 0.0;
        for piece in &pieces {
            assert_eq!((piece.start, piece.length), (at, Piece::SHORTEST));
            at += piece.length;
            assert_eq!(piece.ends_step(), at == 1.0);
        }
    }
}

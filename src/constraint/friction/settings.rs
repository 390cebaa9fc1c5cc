//! The coefficients of friction as a scene has them.

#[cfg(feature = "files")]
use schemars::JsonSchema;
#[cfg(feature = "files")]
use serde::{Deserialize, Serialize};

/// The largest coefficient that a scene may have: rubber on rubber has about 1, and the law is hard to solve above.
pub(crate) const LARGEST_COEFFICIENT: f64 = 10.0;

/// Coefficients of Coulomb friction, each between 0 and 10. In a scene file a number stands for all contacts.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "files", derive(Serialize, Deserialize, JsonSchema), serde(deny_unknown_fields, default))]
#[non_exhaustive]
pub struct Friction {
    /// Between two bodies.
    #[cfg_attr(feature = "files", schemars(range(min = 0, max = 10)))]
    pub bodies: f64,
    /// Between a body and a wall that has no `friction` of its own.
    #[cfg_attr(feature = "files", schemars(range(min = 0, max = 10)))]
    pub walls: f64,
    /// Between the bodies of two groups, in place of `bodies`.
    #[cfg_attr(feature = "files", serde(skip_serializing_if = "Vec::is_empty"))]
    pub groups: Vec<GroupFriction>,
}

/// The coefficient of friction between the bodies of two groups.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "files", derive(Serialize, Deserialize, JsonSchema), serde(deny_unknown_fields))]
#[non_exhaustive]
pub struct GroupFriction {
    /// The groups; twice the same for the bodies of one.
    pub between: [String; 2],
    /// The coefficient.
    #[cfg_attr(feature = "files", schemars(range(min = 0, max = 10)))]
    pub is: f64,
}

impl Friction {
    /// The same coefficient for all contacts.
    ///
    /// ```
    /// use relcp::scene::Friction;
    /// let friction = Friction::of_all(0.3);
    /// assert_eq!((friction.bodies, friction.walls), (0.3, 0.3));
    /// ```
    pub const fn of_all(coefficient: f64) -> Friction {
        Friction { bodies: coefficient, walls: coefficient, groups: Vec::new() }
    }

    /// Whether no contact has friction, unless a wall has its own.
    pub fn is_none(&self) -> bool {
        *self == Friction::default()
    }
}

#[cfg(feature = "files")]
impl super::number_or_object::NumberStands for Friction {
    const EITHER: &'static str = "NumberOrFriction";
    const KEYS: &'static str = "`bodies`, `walls` or `groups`";
    const LARGEST: u32 = LARGEST_COEFFICIENT as u32;
    fn of_all(coefficient: f64) -> Self {
        Friction::of_all(coefficient)
    }
    fn number(&self) -> Option<f64> {
        (*self == Friction::of_all(self.bodies)).then_some(self.bodies)
    }
}

/// Coefficients of restitution, each between 0 and 1: bodies leave with this part of the speed they came with. In a
/// scene file a number stands for all contacts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "files", derive(Serialize, Deserialize, JsonSchema), serde(deny_unknown_fields, default))]
#[non_exhaustive]
pub struct Restitution {
    /// Between two bodies.
    #[cfg_attr(feature = "files", schemars(range(min = 0, max = 1)))]
    pub bodies: f64,
    /// Between a body and a wall.
    #[cfg_attr(feature = "files", schemars(range(min = 0, max = 1)))]
    pub walls: f64,
}

impl Restitution {
    /// The same coefficient for all contacts.
    ///
    /// ```
    /// use relcp::scene::Restitution;
    /// assert_eq!(Restitution::of_all(0.8).walls, 0.8);
    /// ```
    pub const fn of_all(coefficient: f64) -> Restitution {
        Restitution { bodies: coefficient, walls: coefficient }
    }

    /// Whether no contact has restitution.
    pub fn is_none(&self) -> bool {
        *self == Restitution::default()
    }
}

#[cfg(feature = "files")]
impl super::number_or_object::NumberStands for Restitution {
    const EITHER: &'static str = "NumberOrRestitution";
    const KEYS: &'static str = "`bodies` or `walls`";
    const LARGEST: u32 = 1;
    fn of_all(coefficient: f64) -> Self {
        Restitution::of_all(coefficient)
    }
    fn number(&self) -> Option<f64> {
        (*self == Restitution::of_all(self.bodies)).then_some(self.bodies)
    }
}

impl GroupFriction {
    /// The coefficient between the bodies of two groups.
    pub fn new(between: [&str; 2], is: f64) -> GroupFriction {
        GroupFriction { between: between.map(String::from), is }
    }
}

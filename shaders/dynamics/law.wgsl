// What laws of motion give, and what they are given.

struct Load { force: vec3r, torque: vec3r }

struct Motion {
    linear: vec3r,
    angular: vec3r,
    translation: real,
    rotation: real,
    root: mat3r, // space axes, symmetric; used by laws whose rotational mobility is no multiple of one
    momentum: vec3r, // with inertia: the angular momentum that the step ends with, or in its middle the impulse of torques
}

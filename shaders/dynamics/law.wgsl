// The results and the inputs of laws of motion.

struct Load { force: vec3r, torque: vec3r }

struct Motion {
    linear: vec3r,
    angular: vec3r,
    translation: real,
    rotation: real,
    root: mat3r, // space axes, symmetric; used by laws whose rotational mobility is not isotropic
    momentum: vec3r, // with inertia: the angular momentum at the step's end, or in its middle the impulse of torques
}

//! Bodies against fixed surfaces: separations against brute force over the bodies' surfaces; walls in scene files and
//! in the program's reports.

mod scenes;
mod separation;

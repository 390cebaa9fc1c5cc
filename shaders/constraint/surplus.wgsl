// The contact of a violation with the separation that makes its row ask for a part of the overlap beyond touching.

fn over_corrected(contact: vec4r) -> vec4r {
    let asked = min(parameters.surplus_part * max(-contact.w, real(0.0)), parameters.surplus_most);
    return vec4r(contact.xyz, contact.w - asked);
}

// shadows/fill: background of a light's image between points takes the depth of the nearest around it, unless five
// consecutive neighbors are background too (Dobrev et al. 2010, Section 3.2).
#import light_filter

const LARGEST = 3.4028234e38;

fn is_looked_at(own: vec4<f32>) -> vec4<bool> {
    return own == nothing();
}

fn floor_of(own: vec4<f32>) -> vec4<f32> {
    return vec4<f32>(LARGEST);
}

// Running sums of a run of a long list: members of Sums, density and number of open ones last.
struct RunSums {
    high: vec4<f32>,
    low: vec4<f32>,
    rest: vec4<f32>,
}

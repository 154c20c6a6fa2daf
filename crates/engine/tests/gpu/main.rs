//! Tests on a device: its layer, passes, methods, each against the float64 reference; and the shaders themselves.

mod abuffer;
mod approximate;
mod brightness;
mod elementary;
mod gpu;
mod image_space;
mod linked_list;
mod one_layer;
mod peel;
mod peel_layers;
mod plan;
mod points;
mod radix;
mod scan;
mod shaders;
mod shadow_texture;
mod shadows;
mod soft;
mod soft_accuracy;
mod soft_express;
mod sorted;
mod spbr;
mod splat;
mod splats;
mod stochastic;
mod stochastic_hardware;

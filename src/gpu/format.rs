//! Texel formats as types, so that an image bound to a shader that declares another format does not compile.

use ash::vk;
use bytemuck::Pod;

/// A texel format.
pub trait Format: 'static + Send + Sync {
    const VK: vk::Format;
    /// The same bytes in Rust.
    type Texel: Pod;
    /// What an image of this format is used for, beside transfers.
    const USAGE: vk::ImageUsageFlags;
    const ASPECT: vk::ImageAspectFlags = vk::ImageAspectFlags::COLOR;
}

/// A format that can be drawn into.
pub trait Color: Format {}

macro_rules! color_formats {
    ($($(#[$doc:meta])* $name:ident = $vk:ident: $texel:ty),* $(,)?) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug)]
        pub enum $name {}
        impl Format for $name {
            const VK: vk::Format = vk::Format::$vk;
            type Texel = $texel;
            const USAGE: vk::ImageUsageFlags = vk::ImageUsageFlags::from_raw(
                vk::ImageUsageFlags::STORAGE.as_raw() | vk::ImageUsageFlags::COLOR_ATTACHMENT.as_raw(),
            );
        }
        impl Color for $name {}
    )*};
}

color_formats! {
    /// `r32f`
    R32f = R32_SFLOAT: f32,
    /// `rg32f`
    Rg32f = R32G32_SFLOAT: [f32; 2],
    /// `rgba32f`
    Rgba32f = R32G32B32A32_SFLOAT: [f32; 4],
    /// `rgba16f`; texels are half floats, as bits.
    Rgba16f = R16G16B16A16_SFLOAT: [u16; 4],
    /// `rgba8`
    Rgba8 = R8G8B8A8_UNORM: [u8; 4],
    /// `r32ui`
    R32ui = R32_UINT: u32,
    /// `rgba32ui`
    Rgba32ui = R32G32B32A32_UINT: [u32; 4],
}

/// 32-bit float depth. Reversed: 1 is the near plane, 0 is infinitely far.
#[derive(Clone, Copy, Debug)]
pub enum D32f {}

impl Format for D32f {
    const VK: vk::Format = vk::Format::D32_SFLOAT;
    type Texel = f32;
    const USAGE: vk::ImageUsageFlags = vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT;
    const ASPECT: vk::ImageAspectFlags = vk::ImageAspectFlags::DEPTH;
}

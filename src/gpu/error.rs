//! What can go wrong between this program and a Vulkan device.

use ash::vk;

pub type Result<T> = std::result::Result<T, Error>;

#[derive(Clone, Debug, thiserror::Error)]
pub enum Error {
    /// No Vulkan loader, or a loader without a driver.
    #[error(
        "no Vulkan driver: {reason}; install one for your GPU, or Mesa's lavapipe \
         (Debian and Ubuntu: apt install libvulkan1 mesa-vulkan-drivers)"
    )]
    Loader { reason: String },
    /// Nothing on this machine matches, or what matches lacks something.
    #[error("{0}")]
    NoDevice(String),
    #[error("the device cannot do this: {0}")]
    Unsupported(String),
    /// The budget would be passed; nothing was allocated.
    #[error(
        "`{name}` needs {} but only {} of the {} that this run may use are left",
        mebibytes(*bytes), mebibytes(limit.saturating_sub(*used)), mebibytes(*limit)
    )]
    MemoryLimit { name: String, bytes: u64, used: u64, limit: u64 },
    /// The device had less than it said.
    #[error("the device has no memory left for `{name}` ({})", mebibytes(*bytes))]
    OutOfMemory { name: String, bytes: u64 },
    /// The device stopped answering; `after` names the passes of the submission.
    #[error("the device was lost during {after}; update its driver, or try another one with --device")]
    Lost { after: String },
    #[error("Vulkan: {op} failed: {result}")]
    Vk { op: &'static str, result: vk::Result },
}

/// Turns the result code of a Vulkan call into an error that names the call.
pub(super) fn vk_error(op: &'static str) -> impl FnOnce(vk::Result) -> Error {
    move |result| match result {
        vk::Result::ERROR_DEVICE_LOST => Error::Lost { after: op.into() },
        vk::Result::ERROR_OUT_OF_DEVICE_MEMORY | vk::Result::ERROR_OUT_OF_HOST_MEMORY => {
            Error::OutOfMemory { name: op.into(), bytes: 0 }
        }
        result => Error::Vk { op, result },
    }
}

fn mebibytes(bytes: u64) -> String {
    format!("{:.1} MiB", bytes as f64 / f64::from(1 << 20))
}

//! The driver's description of the fault that lost a device.

use std::ffi::c_char;

use ash::vk;

use crate::core::device::Device;
use crate::core::error::{Called, Error};
use crate::core::loss_report::{DeviceFault, address_text};

/// The most parts of a description that are read. A driver that counts more is not believed.
const MOST_PARTS: u32 = 256;

impl Device {
    /// Returns the driver's description of the fault that lost the device; `None` if the device
    /// lacks [`crate::OptionalFeature::DeviceFault`], and unless it is [known to be
    /// lost](Device::is_known_lost). A description that cannot be read is only logged, since the
    /// device is lost anyway.
    pub fn fault(&self) -> Option<DeviceFault> {
        match self.read_fault() {
            Ok(fault) => fault,
            Err(error) => {
                tracing::warn!("the fault of the lost device cannot be read: {error}");
                None
            }
        }
    }

    fn read_fault(&self) -> Result<Option<DeviceFault>, Error> {
        // Only a lost device may be asked (VUID-vkGetDeviceFaultInfoEXT-device-07336).
        let functions = self.extensions().fault.as_ref().filter(|_| self.is_known_lost());
        let Some(functions) = functions else { return Ok(None) };
        let read = functions.fp().get_device_fault_info_ext;
        let device = self.raw().handle();
        let mut counts = vk::DeviceFaultCountsEXT::default();
        // SAFETY: the extension is enabled, and the device is lost; without a place for infos, only
        // the counts are written.
        unsafe { read(device, &raw mut counts, std::ptr::null_mut()) }
            .result()
            .called("vkGetDeviceFaultInfoEXT")?;
        counts.address_info_count = counts.address_info_count.min(MOST_PARTS);
        counts.vendor_info_count = counts.vendor_info_count.min(MOST_PARTS);
        // The dump is for the driver's maker, and may be large.
        counts.vendor_binary_size = 0;
        let mut addresses =
            vec![vk::DeviceFaultAddressInfoEXT::default(); counts.address_info_count as usize];
        let mut codes =
            vec![vk::DeviceFaultVendorInfoEXT::default(); counts.vendor_info_count as usize];
        let mut info = vk::DeviceFaultInfoEXT {
            p_address_infos: addresses.as_mut_ptr(),
            p_vendor_infos: codes.as_mut_ptr(),
            ..Default::default()
        };
        // SAFETY: the lists have as many places as the counts say.
        match unsafe { read(device, &raw mut counts, &raw mut info) } {
            // The dump is left out.
            vk::Result::SUCCESS | vk::Result::INCOMPLETE => {}
            code => return Err(code).called("vkGetDeviceFaultInfoEXT"),
        }
        addresses.truncate(counts.address_info_count as usize);
        codes.truncate(counts.vendor_info_count as usize);
        let code_text = |code: &vk::DeviceFaultVendorInfoEXT| {
            let text = text_of(&code.description);
            format!(
                "{text} (code {:#x}, data {:#x})",
                code.vendor_fault_code, code.vendor_fault_data
            )
        };
        Ok(Some(DeviceFault {
            description: text_of(&info.description),
            addresses: addresses.iter().map(address_text).collect(),
            codes: codes.iter().map(code_text).collect(),
        }))
    }
}

/// Returns a text of a driver, up to its end or to its zero.
fn text_of(text: &[c_char]) -> String {
    let bytes: Vec<u8> =
        text.iter().map(|letter| letter.to_ne_bytes()[0]).take_while(|byte| *byte != 0).collect();
    String::from_utf8_lossy(&bytes).into_owned()
}

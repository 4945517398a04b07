//! A device that claims to describe the fault that lost it.

use std::ffi::{CStr, c_char};
use std::mem::transmute;

use ash::vk;

use super::{Function, injected};

/// The description that the device gives.
pub const FAULT_DESCRIPTION: &CStr = c"a page fault of the test";

/// The address at which it claims that a shader has read.
pub const FAULT_ADDRESS: u64 = 0xABCD_0000;

/// Returns the function of the extension, if the device claims to have it.
pub(super) fn pretended(name: &CStr) -> vk::PFN_vkVoidFunction {
    let is_ours = name == c"vkGetDeviceFaultInfoEXT" && injected(|m| m.describes_faults);
    // SAFETY: both are function pointers, and the caller knows the type by the name.
    is_ours.then(|| unsafe { transmute::<vk::PFN_vkGetDeviceFaultInfoEXT, Function>(fault_info) })
}

unsafe extern "system" fn fault_info(
    _: vk::Device,
    counts: *mut vk::DeviceFaultCountsEXT<'_>,
    info: *mut vk::DeviceFaultInfoEXT<'_>,
) -> vk::Result {
    // SAFETY: the caller passes valid pointers, and lists as long as the counts say.
    unsafe {
        if info.is_null() {
            (*counts).address_info_count = 1;
            (*counts).vendor_info_count = 1;
            (*counts).vendor_binary_size = 4096;
            return vk::Result::SUCCESS;
        }
        let room = [(*counts).address_info_count, (*counts).vendor_info_count];
        assert_eq!((room, (*counts).vendor_binary_size), ([1, 1], 0));
        write(&mut (*info).description, FAULT_DESCRIPTION);
        (*info).p_address_infos.write(vk::DeviceFaultAddressInfoEXT {
            address_type: vk::DeviceFaultAddressTypeEXT::READ_INVALID,
            reported_address: FAULT_ADDRESS,
            address_precision: 4096,
        });
        let mut code = vk::DeviceFaultVendorInfoEXT {
            vendor_fault_code: 7,
            vendor_fault_data: 9,
            ..Default::default()
        };
        write(&mut code.description, c"the seventh");
        (*info).p_vendor_infos.write(code);
    }
    // The dump has no place.
    vk::Result::INCOMPLETE
}

fn write(to: &mut [c_char], text: &CStr) {
    for (to, from) in to.iter_mut().zip(text.to_bytes_with_nul()) {
        *to = *from as c_char;
    }
}

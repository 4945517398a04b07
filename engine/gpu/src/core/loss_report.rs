//! The state of a device that was lost: the frames that it did not finish, and the driver's words.

use std::fmt;

use ash::vk;

use crate::core::tick::Tick;

/// A frame that was submitted and is not known to be over.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UnfinishedFrame {
    /// The tick of the frame.
    pub tick: Tick,
    /// The labels of its passes, in the order in which they were recorded.
    pub passes: Vec<&'static str>,
}

/// The driver's description of a fault (`VK_EXT_device_fault`).
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct DeviceFault {
    /// The description of the fault.
    pub description: String,
    /// The addresses of invalid accesses, and of instructions, as text.
    pub addresses: Vec<String>,
    /// The driver's own codes, each with its description.
    pub codes: Vec<String>,
}

/// The facts about a lost device, for a log or a report to its maker.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LossReport {
    /// The newest tick that was submitted to the device.
    pub submitted: Tick,
    /// The newest tick that is known to be over.
    pub completed: Tick,
    /// The frames in flight, the oldest first. The loss happened in the first of them at the
    /// earliest.
    pub unfinished: Vec<UnfinishedFrame>,
    /// The driver's description, if it has any.
    pub fault: Option<DeviceFault>,
}

impl LossReport {
    /// Returns true if work of this device was unfinished, so that the loss may be due to it.
    /// Otherwise something else lost the device: another program, the driver, or a laptop that
    /// slept.
    pub fn is_ours(&self) -> bool {
        self.submitted > self.completed
    }
}

impl fmt::Display for LossReport {
    fn fmt(&self, text: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { submitted, completed, unfinished, fault } = self;
        if self.is_ours() {
            write!(text, "of {} submits {} were over", submitted.0, completed.0)?;
        } else {
            write!(text, "all {} submits were over, so the loss is not due to them", submitted.0)?;
        }
        for UnfinishedFrame { tick, passes } in unfinished {
            write!(text, "; unfinished {}: {}", tick.0, passes.join(", "))?;
        }
        match fault {
            Some(DeviceFault { description, addresses, codes }) => {
                write!(text, "; the driver says: {description}")?;
                addresses.iter().chain(codes).try_for_each(|more| write!(text, ", {more}"))
            }
            None => Ok(()),
        }
    }
}

/// Returns an address of a fault as text. The driver knows it up to a power of two.
pub(crate) fn address_text(info: &vk::DeviceFaultAddressInfoEXT) -> String {
    let what = match info.address_type {
        vk::DeviceFaultAddressTypeEXT::READ_INVALID => "an invalid read",
        vk::DeviceFaultAddressTypeEXT::WRITE_INVALID => "an invalid write",
        vk::DeviceFaultAddressTypeEXT::EXECUTE_INVALID => "invalid instructions",
        vk::DeviceFaultAddressTypeEXT::INSTRUCTION_POINTER_UNKNOWN => "an instruction",
        vk::DeviceFaultAddressTypeEXT::INSTRUCTION_POINTER_INVALID => "an invalid instruction",
        vk::DeviceFaultAddressTypeEXT::INSTRUCTION_POINTER_FAULT => "a faulting instruction",
        _ => "something",
    };
    let precision = info.address_precision.max(1);
    format!("{what} at {:#x} (within {precision:#x} bytes)", info.reported_address)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_report_names_the_passes_and_the_blame() {
        let mut report = LossReport {
            submitted: Tick(7),
            completed: Tick(5),
            unfinished: vec![
                UnfinishedFrame { tick: Tick(6), passes: vec!["upload", "draw visible"] },
                UnfinishedFrame { tick: Tick(7), passes: vec!["upload"] },
            ],
            fault: None,
        };
        assert!(report.is_ours());
        let text = "of 7 submits 5 were over; unfinished 6: upload, draw visible; unfinished 7: \
                    upload";
        assert_eq!(report.to_string(), text);
        let info = vk::DeviceFaultAddressInfoEXT {
            address_type: vk::DeviceFaultAddressTypeEXT::READ_INVALID,
            reported_address: 0xABC0,
            address_precision: 16,
        };
        report.fault = Some(DeviceFault {
            description: "page fault".to_owned(),
            addresses: vec![address_text(&info)],
            codes: vec!["MMU 3".to_owned()],
        });
        let more = "; the driver says: page fault, an invalid read at 0xabc0 (within 0x10 bytes), \
                    MMU 3";
        assert_eq!(report.to_string(), format!("{text}{more}"));
        let idle = LossReport {
            submitted: Tick(5),
            unfinished: Vec::new(),
            fault: None,
            completed: Tick(5),
        };
        assert!(!idle.is_ours());
        assert_eq!(idle.to_string(), "all 5 submits were over, so the loss is not due to them");
    }
}

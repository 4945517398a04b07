//! A Vulkan loader in which one function fails, for programs that find their loader themselves.

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::Scratch;
use crate::loader_library::LoaderLibrary;

/// A fault of Vulkan that repeats until the program ends.
#[derive(Debug)]
struct VulkanFault {
    /// The function, which returns a `VkResult` and takes at most six arguments.
    function: &'static str,
    /// The first call that fails.
    first_call: FirstCall,
    /// The `VkResult`.
    code: i32,
    /// The name of the code, without `VK_`.
    code_name: &'static str,
}

/// The place of a call among all calls of its function.
#[derive(Clone, Copy, Debug)]
enum FirstCall {
    /// Counted from 1, from the start of the program.
    Nth(i32),
    /// So many calls before the last one of a run without a fault.
    BeforeLast(i32),
}

/// The faults that a program without a window meets, from its start to the submit of one
/// of its last frames.
const HEADLESS_FAULTS: [VulkanFault; 6] = [
    VulkanFault {
        function: "vkCreateInstance",
        first_call: FirstCall::Nth(1),
        code: -1,
        code_name: "ERROR_OUT_OF_HOST_MEMORY",
    },
    VulkanFault {
        function: "vkCreateDevice",
        first_call: FirstCall::Nth(1),
        code: -3,
        code_name: "ERROR_INITIALIZATION_FAILED",
    },
    VulkanFault {
        function: "vkAllocateMemory",
        first_call: FirstCall::Nth(1),
        code: -2,
        code_name: "ERROR_OUT_OF_DEVICE_MEMORY",
    },
    VulkanFault {
        function: "vkCreateGraphicsPipelines",
        first_call: FirstCall::Nth(2),
        code: -2,
        code_name: "ERROR_OUT_OF_DEVICE_MEMORY",
    },
    VulkanFault {
        function: "vkQueueSubmit2",
        first_call: FirstCall::BeforeLast(3),
        code: -4,
        code_name: "ERROR_DEVICE_LOST",
    },
    VulkanFault {
        function: "vkWaitSemaphores",
        first_call: FirstCall::Nth(3),
        code: -4,
        code_name: "ERROR_DEVICE_LOST",
    },
];

/// The loader, in which one function fails.
struct FaultyLoader(LoaderLibrary);

impl FaultyLoader {
    /// Gives the library to a program, in which `function` returns `code` from a call on.
    fn inject(&self, program: &mut Command, function: &str, first_call: i32, code: i32) {
        self.0.give(program);
        program
            .env("CALLS", self.0.folder.0.join("calls"))
            .env("FAULT", format!("{function} {first_call} {code}"));
    }

    /// Runs a program without a fault, and returns how often it calls a function.
    fn calls(&self, program: &mut Command, function: &str) -> i32 {
        self.inject(program, function, i32::MAX, 0);
        let output = program.output().expect("it starts");
        assert!(output.status.success(), "{}", crate::stderr(&output));
        let calls = fs::read_to_string(self.0.folder.0.join("calls")).expect("it was written");
        calls.parse().expect("a number")
    }
}

/// Checks that a program without a window ends with 1 after each of `HEADLESS_FAULTS`, with an
/// error that names the call and the code. `program` makes the command in a folder that is empty
/// again.
pub fn assert_faults_end_programs(name: &str, program: impl Fn(&Path) -> Command) {
    let source = include_str!("faulty_loader.c");
    let loader = FaultyLoader(LoaderLibrary::compile(&format!("{name}-loader"), source));
    for fault in &HEADLESS_FAULTS {
        let scratch = Scratch::new(name);
        let first_call = match fault.first_call {
            FirstCall::Nth(number) => number,
            FirstCall::BeforeLast(before) => {
                let last = loader.calls(&mut program(&scratch.0), fault.function);
                assert!(last > before, "{fault:?} of {last} calls");
                last - before
            }
        };
        let mut command = program(&scratch.0);
        loader.inject(&mut command, fault.function, first_call, fault.code);
        let output = command.output().expect("it starts");
        let message = crate::stderr(&output);
        assert_eq!(output.status.code(), Some(1), "{fault:?}: {message}");
        let error = message.lines().find(|line| line.contains("error: ")).unwrap_or_default();
        assert!(error.contains(fault.function), "{fault:?}: {message}");
        assert!(error.contains(fault.code_name), "{fault:?}: {message}");
        assert!(!message.contains("panicked"), "{fault:?}: {message}");
    }
}

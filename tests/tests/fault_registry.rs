//! The table of calls that can fail is that of Vulkan's registry, and has every call that the
//! engine uses.
//!
//! `ANTUMBRA_WRITE=1 cargo test --test fault_registry` writes the table anew, from the registry of
//! the package `libvulkan-dev`. Calls that the crate `ash` does not know are left out.
#![forbid(unsafe_code)]
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use gpu::SwapchainOptions;
use roxmltree::{Document, Node};
use tests::Driver;
use tests::every_call::{self, table_version};
use tests::window_fixture::WindowStage;
use tests::x11_window::{Library, X11Window};
use tests::xvfb::Xvfb;

const REGISTRY: &str = "/usr/share/vulkan/registry/vk.xml";

/// Calls whose older name `ash` does not have as a type.
const RENAMED: [(&str, &str); 2] = [
    ("vkGetCalibratedTimestampsEXT", "vkGetCalibratedTimestampsKHR"),
    (
        "vkGetPhysicalDeviceCalibrateableTimeDomainsEXT",
        "vkGetPhysicalDeviceCalibrateableTimeDomainsKHR",
    ),
];

const COMMAND: &str = "`ANTUMBRA_WRITE=1 cargo test --test fault_registry`";

/// A call of the registry.
struct Call {
    arguments: usize,
    /// All codes but `SUCCESS`.
    codes: Vec<String>,
}

/// The calls that return a `VkResult`, their other names, and the calls that return none.
#[derive(Default)]
struct Registry {
    version: String,
    calls: BTreeMap<String, Call>,
    aliases: BTreeMap<String, String>,
    others: BTreeSet<String>,
}

fn child<'a, 'b>(node: Node<'a, 'b>, name: &str) -> Option<Node<'a, 'b>> {
    node.children().find(|node| node.has_tag_name(name))
}

fn text_of(node: Node<'_, '_>, name: &str) -> String {
    child(node, name).and_then(|node| node.text()).unwrap_or_default().to_owned()
}

impl Registry {
    fn read() -> Self {
        let text = std::fs::read_to_string(REGISTRY).unwrap_or_else(|error| {
            panic!("{REGISTRY}: {error}\nRun `ci/setup --tests` first: it installs libvulkan-dev.")
        });
        let document = Document::parse(&text).expect("XML");
        let mut registry = Self::default();
        for node in document.descendants() {
            if node.has_tag_name("type") && text_of(node, "name") == "VK_HEADER_VERSION" {
                let number = child(node, "name").and_then(|name| name.tail());
                registry.version = format!("1.3.{}", number.expect("a version").trim());
            }
            if node.has_tag_name("command") {
                registry.add(node);
            }
        }
        registry.rename();
        registry
    }

    fn add(&mut self, node: Node<'_, '_>) {
        if let (Some(name), Some(alias)) = (node.attribute("name"), node.attribute("alias")) {
            self.aliases.insert(name.to_owned(), alias.to_owned());
        }
        let Some(proto) = child(node, "proto") else { return };
        let name = text_of(proto, "name");
        if text_of(proto, "type") != "VkResult" {
            self.others.insert(name);
            return;
        }
        let is_argument = |node: &Node<'_, '_>| {
            node.has_tag_name("param") && node.attribute("api") != Some("vulkansc")
        };
        let list = |name| node.attribute(name).unwrap_or_default().split(',');
        let codes = list("successcodes").chain(list("errorcodes"));
        let codes = codes.filter_map(|code| code.strip_prefix("VK_"));
        let codes = codes.filter(|code| *code != "SUCCESS").map(str::to_owned).collect();
        let arguments = node.children().filter(is_argument).count();
        self.calls.insert(name, Call { arguments, codes });
    }

    /// Keeps the aliases of the calls, and gives calls the names that `ash` has.
    fn rename(&mut self) {
        for (old, new) in RENAMED {
            if let Some(call) = self.calls.remove(old) {
                self.calls.insert(new.to_owned(), call);
                self.aliases.insert(old.to_owned(), new.to_owned());
            }
        }
        let others = self.aliases.iter().filter(|(_, name)| self.others.contains(*name));
        let others: Vec<String> = others.map(|(alias, _)| alias.clone()).collect();
        self.others.extend(others);
        self.aliases.retain(|_, name| self.calls.contains_key(name));
    }

    /// Returns the text of `codes.txt`.
    fn codes(&self) -> String {
        let mut text = format!(
            "# Vulkan {}: the calls that return a VkResult with the codes that they may return, then the\n\
             # aliases. Written by {COMMAND}.\n",
            self.version
        );
        for (name, call) in &self.calls {
            text += name;
            call.codes.iter().for_each(|code| text += &format!(" {code}"));
            text.push('\n');
        }
        for (alias, name) in &self.aliases {
            text += &format!("{alias} = {name}\n");
        }
        text
    }

    /// Returns the text of `calls.rs`.
    fn list(&self) -> String {
        let mut text = format!(
            "//! The calls of the registry that return a `VkResult`, by their number of arguments. Written by\n\
             //! {COMMAND}.\n\n\
             use super::numbered::numbered;\n\nnumbered! {{\n"
        );
        let numbers: BTreeSet<usize> = self.calls.values().map(|call| call.arguments).collect();
        for number in numbers {
            text += &format!("    wrap_{number}:\n");
            let mut line = " ".repeat(7);
            for (name, _) in self.calls.iter().filter(|(_, call)| call.arguments == number) {
                if line.len() + " PFN_".len() + name.len() > 99 {
                    text += &(line + "\n");
                    line = " ".repeat(7);
                }
                line += &format!(" PFN_{name}");
            }
            text += &(line + ";\n");
        }
        text + "}\n"
    }
}

#[test]
fn the_table_is_that_of_the_registry() {
    let registry = Registry::read();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/every_call");
    let files = [("codes.txt", registry.codes()), ("calls.rs", registry.list())];
    for (name, text) in files {
        let path = folder.join(name);
        if std::env::var_os("ANTUMBRA_WRITE").is_some() {
            std::fs::write(&path, text).expect("the table is written");
        } else if registry.version == table_version() {
            let committed = std::fs::read_to_string(&path).expect("the table");
            assert!(committed == text, "{name} is not that of {REGISTRY}: {COMMAND} writes it");
        } else {
            println!(
                "skipped: {name} is of {}, and {REGISTRY} of {}",
                table_version(),
                registry.version
            );
        }
    }
}

#[test]
fn every_function_that_the_engine_asks_for_can_fail_or_returns_no_code() {
    let registry = Registry::read();
    let server = Xvfb::start();
    for driver in Driver::ALL {
        let window = X11Window::open(&server, Library::Xcb, [64, 64]);
        let stage = WindowStage::with_entry(every_call::entry(), driver, window);
        drop(stage.swapchain(&SwapchainOptions::default()));
        stage.end();
    }
    let asked = every_call::asked();
    assert!(asked.len() > 200, "{asked:?}");
    let missing: Vec<_> = asked
        .iter()
        .filter(|name| every_call::number_of(name).is_none())
        .filter(|name| !registry.others.contains(*name))
        .collect();
    assert!(missing.is_empty(), "no wrapper: {missing:?}");
}

//! The text of the page of a device, as Markdown.

use antumbra::gpu::Adapter;
use antumbra::render::{CheckResult, CostItem, CostListOptions, ItemCost, SelfTest};

use crate::gpu_page::walks;
use crate::provenance::Provenance;
use crate::report::Report;
use crate::result_page::{ResultPage, Table, Tone};

/// The contents of the page of a device.
pub struct DevicePage<'a> {
    /// The device.
    pub adapter: &'a Adapter,
    /// The command line and the time of the measurement.
    pub provenance: &'a Provenance,
    /// The commit of the code.
    pub commit: Option<&'a str>,
    /// True if the code has changes that are not in it.
    pub has_changes: bool,
    /// The outcome of the self-test.
    pub quirks: &'a SelfTest,
    /// The options that the costs were measured with.
    pub options: CostListOptions,
    /// The costs.
    pub device_costs: &'a [ItemCost],
    /// The walks on this device.
    pub reports: &'a [Report],
    /// The walks that it cannot do, a sentence each.
    pub left_out: &'a [String],
    /// The file of the plot, beside the page.
    pub plot: String,
}

/// Returns the name of a device as a file's: letters, digits, one underscore between them.
pub fn file_stem(name: &str) -> String {
    let words = name.split(|letter: char| !letter.is_ascii_alphanumeric());
    let words: Vec<&str> = words.filter(|word| !word.is_empty()).collect();
    words.join("_").to_lowercase()
}

/// Returns a text about the kind of device and the use of its figures.
fn purpose(name: &str, is_software: bool) -> &'static str {
    const COMPUTE: [&str; 10] =
        ["A100", "A800", "B100", "B200", "GH200", "H100", "H200", "H800", "P100", "V100"];
    let is_compute = |word: &str| {
        COMPUTE.contains(&word) || ["MI1", "MI2", "MI3"].iter().any(|name| word.starts_with(name))
    };
    if is_software {
        return "This device draws on the CPU. Exactness found here holds for its driver. Ratios of \
                strategies within this page mean something for software drivers alone, and costs \
                even less: on a GPU a box costs next to nothing, and breaks and empty draws count.";
    }
    if name.split(|letter: char| !letter.is_alphanumeric()).any(is_compute) {
        return "This is a GPU of a data centre: it draws triangles on few of its units (an H100 on 2 \
                of 66), and computes on all. Exactness found here holds. Costs compare raster with \
                raster only: compute looks many times cheaper than on a GPU for games.";
    }
    "This is a GPU: exactness, costs and ratios found here hold for it and this driver. Other \
     machines have other ratios: measure them by the same command."
}

impl DevicePage<'_> {
    /// Returns the page.
    pub fn page(&self) -> ResultPage {
        let Adapter { name, driver, api, .. } = self.adapter;
        let command = self.provenance.command.join(" ");
        let changes = if self.has_changes { " and changes that are not committed" } else { "" };
        let commit =
            self.commit.map_or(String::new(), |commit| format!(", commit {commit}{changes}"));
        let day = self.provenance.day();
        let mut page = ResultPage::new(name);
        page.text(
            Tone::Faint,
            &format!("{driver}, Vulkan {api}; {day}{commit}. Made by `ci/gpu` (`{command}`)."),
        );
        page.text(Tone::Plain, purpose(name, self.adapter.is_software()));
        self.trusted(&mut page);
        walks::exactness(&mut page, self.reports, self.left_out);
        self.cost_table(&mut page);
        walks::timed(&mut page, self.reports);
        page
    }

    /// Returns the cost of each item in the largest number that was measured.
    pub fn bars(&self) -> Vec<(String, Option<f64>)> {
        let last = |item: CostItem| self.device_costs.iter().rev().find(|cost| cost.item == item);
        let bar = |item: CostItem| {
            last(item).map(|cost| (item.name(), Some(cost.each_ns().max(0.0).round())))
        };
        CostItem::all().into_iter().filter_map(bar).collect()
    }

    fn trusted(&self, page: &mut ResultPage) {
        page.heading("What the driver is trusted with");
        page.text(
            Tone::Plain,
            "The [self-test](../book/src/drivers.md#what-a-driver-is-trusted-with) found:",
        );
        let findings = self.quirks.findings.iter();
        let rows = findings.map(|(assumption, finding)| {
            [assumption.name(), finding.word(), finding.detail()].map(str::to_owned).to_vec()
        });
        page.table(&Table::of(&["assumption", "verdict", "seen"], rows.collect()));
        let broken = |(_, finding): &&(_, CheckResult)| matches!(finding, CheckResult::Failed(_));
        let verdict = match (self.quirks.findings.iter().filter(broken).count(), self.quirks.safest)
        {
            (0, _) => "Nothing is broken.".to_owned(),
            (_, Some(strategy)) => format!("The safest strategy is `{strategy}`."),
            (_, None) => "Only plain frustum culling is safe.".to_owned(),
        };
        page.text(Tone::Plain, &verdict);
    }

    fn cost_table(&self, page: &mut ResultPage) {
        let CostListOptions { size: [width, height], rounds, .. } = self.options;
        page.heading("Costs");
        page.text(
            Tone::Plain,
            &format!(
                "Nanoseconds of one, of so many in a frame of {width}x{height}: medians of {rounds} \
                 rounds in which all take turns, above a frame without any; by the GPU's timestamps \
                 where it has them, resets by the CPU's clock. `-`: not measured, since it would take \
                 too long, or no frame has so many. Below 0: less than the noise."
            ),
        );
        page.text(Tone::Plain, &format!("![Costs]({})", self.plot));
        let mut counts: Vec<u32> = self.device_costs.iter().map(|cost| cost.count).collect();
        counts.sort_unstable();
        counts.dedup();
        let heads: Vec<String> = counts.iter().map(u32::to_string).collect();
        let columns: Vec<&str> =
            ["item"].into_iter().chain(heads.iter().map(String::as_str)).collect();
        let is_measured = |item: &CostItem| self.device_costs.iter().any(|cost| cost.item == *item);
        let row = |item: CostItem| {
            let each_ns = |count: &u32| {
                let same = |cost: &&ItemCost| cost.item == item && cost.count == *count;
                let cost = self.device_costs.iter().find(same);
                cost.map_or("-".to_owned(), |cost| format!("{:.0}", cost.each_ns()))
            };
            [item.name()].into_iter().chain(counts.iter().map(each_ns)).collect()
        };
        let rows = CostItem::all().into_iter().filter(is_measured).map(row).collect();
        page.table(&Table::of(&columns, rows));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_become_files() {
        assert_eq!(file_stem("llvmpipe (LLVM 15.0.6, 256 bits)"), "llvmpipe_llvm_15_0_6_256_bits");
        assert_eq!(file_stem("NVIDIA H100 80GB HBM3"), "nvidia_h100_80gb_hbm3");
    }

    #[test]
    fn a_page_says_what_it_may_be_used_for() {
        assert!(purpose("llvmpipe", true).contains("on the CPU"));
        assert!(purpose("NVIDIA H100 80GB HBM3", false).contains("raster only"));
        assert!(purpose("AMD Instinct MI250X", false).contains("raster only"));
        for name in ["AMD Radeon RX 7900", "NVIDIA RTX A1000"] {
            assert!(purpose(name, false).starts_with("This is a GPU:"), "{name}");
        }
    }
}

//! Faults as text, and the choice of the faults of many runs.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Mutex;

use ash::vk;
use tests::every_call::{
    CallNumber, Fault, FaultPlan, INVENTED, Lasts, NextFault, call_matters, codes_of, name_of,
    number_of, parse_code,
};
use tests::window_fixture::Random;

/// Reads a plan as [`write`] writes it: `vkCreateBuffer 3 ERROR_OUT_OF_HOST_MEMORY once`, and for a
/// second fault ` then 17 99`: after 17 calls that do not name objects, with the seed 99.
pub fn parse(text: &str) -> FaultPlan {
    let words: Vec<&str> = text.split(' ').collect();
    let [call, nth, code, lasts, ref rest @ ..] = words[..] else { panic!("not a plan: {text}") };
    let first = Fault {
        call: number_of(call).unwrap_or_else(|| panic!("no call: {text}")),
        nth: nth.parse().expect("a number"),
        code: parse_code(code).unwrap_or_else(|| panic!("no code: {text}")),
        lasts: if lasts == "once" { Lasts::Once } else { Lasts::Forever },
    };
    let second = match rest {
        ["then", after, seed] => Some(NextFault {
            after: after.parse().expect("a number"),
            seed: seed.parse().expect("a number"),
        }),
        _ => None,
    };
    FaultPlan { first: Some(first), second }
}

/// Writes the first fault of a plan, and the second one.
pub fn write(fault: &Fault, second: Option<NextFault>) -> String {
    let Fault { call, nth, code, lasts } = fault;
    let lasts = if *lasts == Lasts::Once { "once" } else { "forever" };
    let then = second.map(|NextFault { after, seed }| format!(" then {after} {seed}"));
    format!("{} {nth} {code:?} {lasts}{}", name_of(*call), then.unwrap_or_default())
}

/// Returns every code that is injected into a call: those that it may return, and two others.
pub fn codes(call: CallNumber) -> Vec<vk::Result> {
    let mut codes = codes_of(call).to_vec();
    codes.extend([vk::Result::ERROR_UNKNOWN, INVENTED]);
    codes.dedup();
    codes
}

/// The functions and codes that programs have taken.
pub type Taken = BTreeSet<(CallNumber, i32)>;

/// Returns `count` faults of a program that makes the calls of `trace`: first the codes of
/// functions that no program has taken, then each other code of each function once, then others at
/// random.
pub fn single(trace: &[CallNumber], count: usize, seed: u64, taken: &Mutex<Taken>) -> Vec<String> {
    let mut random = Random::new(seed);
    let mut calls = BTreeMap::<CallNumber, usize>::new();
    for call in trace {
        *calls.entry(*call).or_default() += 1;
    }
    let every = calls
        .iter()
        .flat_map(|(call, times)| codes(*call).into_iter().map(move |code| (*call, *times, code)));
    let mut chosen: Vec<Fault> = every
        .map(|(call, times, code)| {
            let nth = random.below(times as u32) as usize;
            Fault { call, nth, code, lasts: lasts(&mut random) }
        })
        .collect();
    shuffle(&mut chosen, &mut random);
    let mut taken = taken.lock().expect("no thread panics");
    chosen.sort_by_key(|fault| taken.contains(&(fault.call, fault.code.as_raw())));
    while chosen.len() < count {
        let place = random.below(trace.len() as u32) as usize;
        chosen.push(fault_at(trace, place, &mut random));
    }
    chosen.truncate(count);
    // In any order, so that the memory that each kind leaves is looked at.
    shuffle(&mut chosen, &mut random);
    taken.extend(chosen.iter().map(|fault| (fault.call, fault.code.as_raw())));
    chosen.iter().map(|fault| write(fault, None)).collect()
}

/// Returns a fault that another one can follow.
pub fn first_of_pair(trace: &[CallNumber], random: &mut Random) -> Fault {
    let places: Vec<usize> = (0..trace.len()).filter(|place| call_matters(trace[*place])).collect();
    let place = places[random.below(places.len() as u32) as usize];
    let first = fault_at(trace, place, random);
    // Of faults that last only a loss ends, with its device.
    let lasts = if first.code == vk::Result::ERROR_DEVICE_LOST { first.lasts } else { Lasts::Once };
    Fault { lasts, ..first }
}

/// Returns `count` faults that follow `first`, each in place of one of the `calls_after` calls that
/// were made after it.
pub fn seconds(
    first: &Fault,
    calls_after: usize,
    count: usize,
    random: &mut Random,
) -> Vec<String> {
    let second = |_| {
        let after = random.below(calls_after as u32) as usize;
        write(first, Some(NextFault { after, seed: u64::from(random.below(u32::MAX)) }))
    };
    (0..count.min(calls_after)).map(second).collect()
}

fn lasts(random: &mut Random) -> Lasts {
    if random.below(2) == 0 { Lasts::Once } else { Lasts::Forever }
}

/// Returns a fault at a place of a trace.
fn fault_at(trace: &[CallNumber], place: usize, random: &mut Random) -> Fault {
    let call = trace[place];
    let nth = trace[..place].iter().filter(|other| **other == call).count();
    let codes = codes(call);
    let code = codes[random.below(codes.len() as u32) as usize];
    Fault { call, nth, code, lasts: lasts(random) }
}

fn shuffle<T>(list: &mut [T], random: &mut Random) {
    for place in (1..list.len()).rev() {
        list.swap(place, random.below(place as u32 + 1) as usize);
    }
}

"""All mutants of a list by cargo-mutants in one program, each behind a number.

The one idea: a mutant costs a build if it is a change of the text, and only a run of tests if it is there already
and waits for its number. Each operator that cargo-mutants would exchange becomes a call that asks for its number, each
function that it would empty begins with the question, each arm that it would delete has it as its guard. Lines keep
their places, so that what the compiler does not like can be taken back, site by site.

    weave.py LIST.json ROOT TREE   weaves the sources of ROOT into TREE, a copy of it, and takes back until `cargo
                                   check` passes; writes TREE/woven.json: the numbers (positions in the list) that are in the program
"""

import json
import re
import subprocess
import sys
from collections import defaultdict
from pathlib import Path

import tree_sitter
import tree_sitter_rust

ARITHMETIC = {"+": "Add", "-": "Sub", "*": "Mul", "/": "Div", "%": "Rem", "<<": "Shl", ">>": "Shr", "&": "BitAnd",
              "|": "BitOr", "^": "BitXor"}
COMPARISON = {"==": "eq", "!=": "ne", "<": "lt", "<=": "le", ">": "gt", ">=": "ge"}
LOGIC = {"&&": "and", "||": "or"}

HEAD = """//! Which mutant is awake: the number in GEARWISE_MUTANT.
#![allow(missing_docs, clippy::all)]
use std::io::Write;
use std::ops::*;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU32, AtomicU8, Ordering::Relaxed};

const NONE: u32 = u32::MAX - 2;
const RECORD: u32 = u32::MAX - 1;
const UNREAD: u32 = u32::MAX;
static AWAKE: AtomicU32 = AtomicU32::new(UNREAD);
static SEEN: [AtomicU8; COUNT] = [const { AtomicU8::new(0) }; COUNT];
static FILE: Mutex<Option<std::fs::File>> = Mutex::new(None);

#[cold]
#[inline(never)]
fn slow(first: u32) -> u32 {
    if AWAKE.load(Relaxed) == UNREAD {
        let mut file = FILE.lock().unwrap();
        if AWAKE.load(Relaxed) == UNREAD {
            let awake = match std::env::var("GEARWISE_REACHED") {
                Ok(path) => {
                    *file = std::fs::File::options().create(true).append(true).open(path).ok();
                    RECORD
                }
                Err(_) => std::env::var("GEARWISE_MUTANT").map_or(NONE, |n| n.parse().unwrap()),
            };
            AWAKE.store(awake, Relaxed);
        }
    }
    let awake = AWAKE.load(Relaxed);
    if awake == RECORD && SEEN[first as usize].load(Relaxed) == 0 && SEEN[first as usize].swap(1, Relaxed) == 0 {
        if let Some(file) = FILE.lock().unwrap().as_mut() {
            let _ = file.write_all(format!("{first}\\n").as_bytes());
        }
    }
    awake
}

/// How far the mutant that is awake is behind this one.
#[inline(always)]
pub fn pick(first: u32) -> u32 {
    let awake = AWAKE.load(Relaxed);
    (if awake >= RECORD { slow(first) } else { awake }).wrapping_sub(first)
}

#[inline(always)]
pub fn on(number: u32) -> bool {
    pick(number) == 0
}

"""


def helper(kind, operator, others):
    """Name and text of the function that stands for an operator with these exchanges."""
    word = {**{k: v.lower() for k, v in ARITHMETIC.items()}, **COMPARISON, **LOGIC}
    name = "_".join([kind] + [word.get(o.rstrip("=") if kind == "assign" else o, "not") for o in [operator, *others]])
    arms = "".join(f"{i} => {{}}, " for i in range(len(others))) + "_ => {}"
    if kind == "binary":
        bounds = " + ".join(f"{ARITHMETIC[o]}<B, Output = O>" for o in [operator, *others])
        text = (f"pub fn {name}<A, B, O>(id: u32, a: A, b: B) -> O where A: {bounds} "
                f"{{ match pick(id) {{ {arms.format(*(f'a {o} b' for o in [*others, operator]))} }} }}")
    elif kind == "assign":
        bounds = " + ".join(f"{ARITHMETIC[o[:-1]]}Assign<B>" for o in [operator, *others])
        text = (f"pub fn {name}<A, B>(id: u32, a: &mut A, b: B) where A: {bounds} "
                f"{{ match pick(id) {{ {arms.format(*(f'*a {o} b' for o in [*others, operator]))} }} }}")
    elif kind == "compare":
        bound = "PartialEq" if operator in ("==", "!=") and all(o in ("==", "!=") for o in others) else "PartialOrd"
        text = (f"pub fn {name}<A: {bound}<B> + ?Sized, B: ?Sized>(id: u32, a: &A, b: &B) -> bool "
                f"{{ match pick(id) {{ {arms.format(*(f'a {o} b' for o in [*others, operator]))} }} }}")
    elif kind == "logic":
        text = (f"pub fn {name}(id: u32, a: bool, b: impl FnOnce() -> bool) -> bool "
                f"{{ match pick(id) {{ {arms.format(*(f'a {o} b()' for o in [*others, operator]))} }} }}")
    else:  # "delete"
        trait = {"-": "Neg", "!": "Not"}[operator]
        name = "delete_" + trait.lower()
        text = (f"pub fn {name}<T: {trait}<Output = T>>(id: u32, x: T) -> T "
                f"{{ if on(id) {{ x }} else {{ {operator}x }} }}")
    return name, "#[inline(always)]\n" + text + "\n"


def write(file, text):
    """Only what changed, so that nothing else is built again."""
    if not file.exists() or file.read_bytes() != text:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(text)


class Weaver:
    def __init__(self, mutants, root, tree):
        self.mutants, self.root, self.tree, self.helpers = mutants, root, tree, {}
        self.parser = tree_sitter.Parser(tree_sitter.Language(tree_sitter_rust.language()))
        self.original = {f: (root / f).read_bytes() for f in {m["file"] for m in mutants}}
        self.unfit = {}

    def call(self, kind, operator, others):
        name, text = helper(kind, operator, others)
        self.helpers[name] = text
        return f"crate::mutant::{name}("

    def place(self, file, where):
        lines = self.original[file].split(b"\n")
        before = sum(len(line) + 1 for line in lines[: where["line"] - 1])
        return before + len(lines[where["line"] - 1].decode()[: where["column"] - 1].encode())

    def weave(self, file):
        source = self.original[file]
        root = self.parser.parse(source).root_node
        sites = defaultdict(list)
        for number, mutant in enumerate(self.mutants):
            if mutant["file"] == file and number not in self.unfit:
                sites[mutant["genre"], self.place(file, mutant["span"]["start"])].append(number)
        # The open ones of one place in order, the closing ones of one place the other way round.
        edits, woven = [], []

        def put(start, end, text, opens, node):
            depth = 0
            while node is not None:
                depth, node = depth + 1, node.parent
            edits.append((start, 1 if opens else 0, depth if opens else -depth, len(edits), end, text))

        arms = defaultdict(dict)
        for (genre, start), numbers in sorted(sites.items(), key=lambda s: (s[0][1], s[1])):
            first = numbers[0]
            replacements = [self.mutants[n]["replacement"] for n in numbers]
            leaf = root.descendant_for_byte_range(start, start + 1)
            node = leaf.parent
            if numbers != list(range(first, first + len(numbers))):
                self.drop(numbers, "numbers are not in a row")
                continue
            if genre == "FnValue" and "impl " in self.mutants[first]["function"]["return_type"]:
                self.drop(numbers, "a function that returns an impl has one type")
            elif genre == "FnValue":
                while leaf is not None and leaf.type != "function_item":
                    leaf = leaf.parent
                body = leaf.child_by_field_name("body")
                text = "".join(f" if crate::mutant::on({n}) {{ return {r}; }}" for n, r in zip(numbers, replacements))
                put(body.start_byte + 1, body.start_byte + 1, text, False, body)
            elif genre == "BinaryOperator":
                operator = source[leaf.start_byte:leaf.end_byte].decode()
                if node.type not in ("binary_expression", "compound_assignment_expr"):
                    self.drop(numbers, f"operator in a {node.type}")
                    continue
                left, right = node.child_by_field_name("left"), node.child_by_field_name("right")
                if node.type == "compound_assignment_expr":
                    kind, opened, between, closed = "assign", "&mut (", "), ", ")"
                elif operator in LOGIC:
                    kind, opened, between, closed = "logic", "", ", || ", ")"
                elif operator in COMPARISON:
                    kind, opened, between, closed = "compare", "&(", "), &(", "))"
                else:
                    kind, opened, between, closed = "binary", "", ", ", ")"
                put(left.start_byte, left.start_byte, self.call(kind, operator, replacements) + f"{first}, {opened}", True, node)
                put(leaf.start_byte, leaf.end_byte, between, True, node)
                put(right.end_byte, right.end_byte, closed, False, node)
            elif genre == "UnaryOperator":
                operator = source[leaf.start_byte:leaf.end_byte].decode()
                if node.type == "negative_literal":
                    node = leaf.parent
                put(leaf.start_byte, leaf.end_byte, self.call("delete", operator, []) + f"{first}, ", True, node)
                put(node.end_byte, node.end_byte, ")", False, node)
            elif genre in ("MatchArm", "MatchArmGuard"):
                while leaf.type != "match_arm":
                    leaf = leaf.parent
                arms[leaf.start_byte, leaf.end_byte][genre] = (leaf, numbers, replacements)
            elif genre == "StructField":
                while leaf.type not in ("field_initializer", "shorthand_field_initializer"):
                    leaf = leaf.parent
                base = next(c for c in leaf.parent.children if c.type == "base_field_initializer")
                base = source[base.start_byte + 2:base.end_byte].decode().replace("\n", " ")
                if leaf.type == "shorthand_field_initializer":
                    name = source[leaf.start_byte:leaf.end_byte].decode()
                    start, value = leaf.start_byte, leaf
                    prefix = f"{name}: "
                else:
                    name = source[leaf.children[0].start_byte:leaf.children[0].end_byte].decode()
                    value, prefix = leaf.child_by_field_name("value"), ""
                put(value.start_byte, value.start_byte,
                    f"{prefix}if crate::mutant::on({first}) {{ ({base}).{name} }} else {{ ", True, leaf)
                put(value.end_byte, value.end_byte, " }", False, leaf)
            woven += numbers
        for found in arms.values():
            arm = next(iter(found.values()))[0]
            pattern = next(c for c in arm.children if c.type == "match_pattern")
            condition = pattern.child_by_field_name("condition")
            deleted = found.get("MatchArm", (None, [None], None))[1][0]
            alive = "" if deleted is None else f"!crate::mutant::on({deleted}) && "
            if condition is None and pattern.child(0).type in ("identifier", "_"):
                self.drop([deleted], "the arm that takes all others")
                continue
            if condition is None:
                put(pattern.end_byte, pattern.end_byte, f" if !crate::mutant::on({deleted})", False, pattern)
                continue
            text = alive + "("
            if "MatchArmGuard" in found:
                _, numbers, replacements = found["MatchArmGuard"]
                for n, r in zip(numbers, replacements):
                    text += f"crate::mutant::on({n}) || " if r == "true" else f"!crate::mutant::on({n}) && ("
            put(condition.start_byte, condition.start_byte, text, True, pattern)
            put(condition.end_byte, condition.end_byte, ")" * (text.count("(") - text.count(")")), False, pattern)
        out, at = bytearray(), 0
        for start, _, _, _, end, text in sorted(edits):
            out += source[at:start] + text.encode()
            at = end
        out += source[at:]
        write(self.tree / file, bytes(out))
        return woven

    def drop(self, numbers, why):
        for n in numbers:
            self.unfit.setdefault(n, why)

    def everything(self):
        woven = sorted(n for file in sorted(self.original) for n in self.weave(file) if n not in self.unfit)
        text = HEAD.replace("COUNT", str(len(self.mutants))) + "\n".join(self.helpers.values())
        for crate in ("model", "select", "identify"):
            write(self.tree / f"crates/{crate}/src/mutant.rs", text.encode())
        for file in (*self.root.glob("src/**/*.rs"), *self.root.glob("crates/*/src/**/*.rs")):
            name = str(file.relative_to(self.root))
            if name.startswith("crates/") and name.endswith("/src/lib.rs"):
                mutant = b"pub mod mutant;\n" if (self.tree / name).with_name("mutant.rs").exists() else b""
                write(self.tree / name, b"#![allow(warnings)]\n" + file.read_bytes() + mutant)
            elif name not in self.original:
                write(self.tree / name, file.read_bytes())
        return woven

    def complaints(self):
        """Numbers at the places of which the compiler complains, with what it says."""
        run = subprocess.run(["cargo", "check", "--workspace", "--exclude", "gearwise-python", "--lib", "--message-format=json"], cwd=self.tree, capture_output=True, text=True)
        found, elsewhere = {}, []
        for line in run.stdout.splitlines():
            message = json.loads(line).get("message")
            if not isinstance(message, dict) or message.get("level") != "error" or not message["spans"]:
                continue
            numbers = set()
            if (message.get("code") or {}).get("code") == "E0004":
                # A guard on an arm that is needed: cargo-mutants would not get it through either.
                span = next(s for s in message["spans"] if s["is_primary"])
                numbers = {n for n, m in enumerate(self.mutants)
                           if m["genre"] == "MatchArm" and m["file"] == span["file_name"]
                           and 0 <= m["span"]["start"]["line"] - span["line_start"] < 20}
            for span in message["spans"]:
                if span["file_name"] in self.original and (span["is_primary"] or not numbers):
                    numbers |= self.at(span)
            for n in numbers:
                found.setdefault(n, message["message"])
            if not numbers:
                elsewhere.append(message["rendered"])
        return found, elsewhere, run.returncode

    def at(self, span):
        """The numbers inside a span of the woven text, or else those of the nearest calls before it in its line."""
        lines = (self.tree / span["file_name"]).read_text().split("\n")
        call = re.compile(r"crate::mutant::(\w+)\((\d+)")
        inside, before = set(), []
        for number in range(span["line_start"], span["line_end"] + 1):
            for match in call.finditer(lines[number - 1]):
                after_start = number > span["line_start"] or match.end() >= span["column_start"]
                before_end = number < span["line_end"] or match.start() + 1 < span["column_end"]
                if after_start and before_end:
                    inside.add(int(match[2]))
                elif not after_start:
                    before.append(int(match[2]))
        chosen = inside or set(before[-1:])
        # With a number goes its whole site.
        whole = set()
        for n in chosen:
            span = self.mutants[n]["span"], self.mutants[n]["file"], self.mutants[n]["genre"]
            if span[2] == "FnValue":
                whole.add(n)
            else:
                whole |= {k for k in range(max(0, n - 3), min(len(self.mutants), n + 4))
                          if (self.mutants[k]["span"], self.mutants[k]["file"], self.mutants[k]["genre"]) == span}
        return whole


def main():
    mutants, root, tree = json.load(open(sys.argv[1])), Path(sys.argv[2]), Path(sys.argv[3])
    weaver = Weaver(mutants, root, tree)
    known = tree / "unfit.json"
    if known.exists():
        # What was disliked before will be again.
        disliked = json.loads(known.read_text())
        weaver.unfit = {n: disliked[m["name"]] for n, m in enumerate(mutants) if m["name"] in disliked}
    for _ in range(20):
        woven = weaver.everything()
        found, elsewhere, status = weaver.complaints()
        print(f"{len(woven)} of {len(mutants)} woven, the compiler dislikes {len(found)}", flush=True)
        if status == 0:
            break
        if not found:
            sys.exit("nothing to take back\n" + "\n".join(elsewhere)[:6000])
        weaver.unfit.update(found)
        known.write_text(json.dumps({mutants[n]["name"]: why for n, why in weaver.unfit.items()}, indent=0))
    (tree / "woven.json").write_text(json.dumps({"woven": woven, "unfit": weaver.unfit}, indent=0))


main()

"""What is mutated, room by room. A room is a set of files; of some only the functions that decide."""

from fnmatch import fnmatch

ROOMS = {
    # The model: shaft torque, voltage, heat, limits, effects that a fitted actuator brings along.
    "actuator": {"crates/model/src/actuator/*.rs": None, "crates/model/src/numerics/laurent.rs": None, "crates/model/src/effects/features.rs": None},
    # The ratio program: window, cones, branch and bound, certificate, prices.
    "program": {"crates/select/src/program/*.rs": None, "crates/model/src/numerics/line_search.rs": None},
    # What the numbers of a data sheet refer to.
    "conventions": {"crates/model/src/catalog/convention.rs": None, "crates/model/src/catalog/sheet.rs": None},
    # What makes identification name an effect, refuse it, or say that something is left. Not the balance, the
    # filter and the search over shapes and orders: what they do wrong, the decisions have to notice.
    "identification": {
        "crates/identify/src/identify/verdict.rs": None,
        "crates/identify/src/identify/structure.rs": None,
        "crates/identify/src/identify/candidates.rs": [
            "carries_another", "Selection::*", "is", "lacks", "is_told_instead", "rank", "evaluate_all", "is_preferred", "evaluate", "own_shares",
            "block_scores", "statistic", "signed_statistic", "chance_threshold", "gain_of", "gain_beside",
            "log_that_objects", "squares_given"],
        "crates/identify/src/identify/artefacts.rs": ["find", "list", "gains", "usual_gains", "lags", "refine", "shows_lags"],
        "crates/identify/src/identify/regression.rs": ["paired", "finite_sum"],
    },
}

# Text for people: what it says is read by the tests of reports, not by those of the model.
TEXT = ["*::fmt", "*fmt"]


def inside(pattern, path):
    # A star does not cross a folder.
    return pattern.count("/") == path.count("/") and fnmatch(path, pattern)


def rooms(mutants):
    """Numbers of the mutants of each room."""
    found = {room: [] for room in ROOMS}
    for number, mutant in enumerate(mutants):
        function = (mutant.get("function") or {}).get("function_name", "")
        if any(fnmatch(function, text) for text in TEXT):
            continue
        for room, files in ROOMS.items():
            for pattern, functions in files.items():
                if inside(pattern, mutant["file"]) and (functions is None or any(fnmatch(function, f) for f in functions)):
                    found[room].append(number)
    return found


if __name__ == "__main__":
    for pattern in (p for files in ROOMS.values() for p in files):
        print(pattern)

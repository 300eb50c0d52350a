#!/usr/bin/env bash
# Makes the fuzzer's dictionaries: every word in quotes of the reader's own source, units, and what its format is made of.
# Run it again where a reader has learnt new words.
set -euo pipefail
cd "$(dirname "$0")/.."

words() { # Words in quotes of the files, as tokens.
    cat "$@" | grep -oE '"[A-Za-z][A-Za-z0-9_.*-]{1,39}"' | sort -u
}
units() {
    printf '"%s"\n' 'N*m' 'mN*m' 'rad/s' 'rpm' 'deg/s' 'rad' 'deg' 'g*cm^2' 'kg*m^2' 'kg' 'g' 'V' 'A' 'W' 'ohm' 'mH' 's' 'ms' \
        'Hz' 'm' 'mm' 'K/W' 'degC' 'K' 'N*m/A' 'V*s/rad' 'rpm/V' 'N*m/rad' 'N*m*s/rad' 'N' '%' 'rad/s^2' 'N*m/s' 'N*m/kg'
}
numbers() {
    printf '"%s"\n' '0' '-1' '1e18' '1e-18' '1e300' '-0' '0.5' '1,5' 'nan' 'inf' '4294967296' '1e-300' '100001'
}
toml() {
    printf '"%s"\n' ' = ' '[[' ']]' '{ ' ' }' '= [' '\"\"\"' "'''" '\\u0000' '\xc3\xa9' '\xef\xbb\xbf' '\r\n' '#' 'true' 'false' '\n== motion.csv ==\n'
}
table() {
    printf '"%s"\n' ' [' ']' ',' '\"' '\r\n' '\n#' '\n' ';' '\xef\xbb\xbf' '_tolerance' '\n== gears.csv ==\n'
}
xml() {
    printf '"%s"\n' '<' '/>' '</' '=\"' '<!--' '-->' '<![CDATA[' ']]>' '&amp;' '&#0;' '<?xml' '<!DOCTYPE' 'xmlns=\"' '\n== motion.csv ==\n'
}
make() { # name, then what prints tokens
    local name=$1
    shift
    for part in "$@"; do eval "$part"; done | sed 's/\\n/\\x0a/g; s/\\r/\\x0d/g' | sort -u | awk '{ printf "t%d=%s\n", NR, $0 }' > "fuzz/dictionaries/$name.dict"
}

mkdir -p fuzz/dictionaries
requirement="words crates/model/src/requirement/*.rs"
make catalogue "words crates/model/src/catalog/*.rs crates/model/src/actuator/effects/*.rs" "grep -oE '^    [a-z_]+: [A-Z]' crates/model/src/catalog/sheet.rs | sed -E 's/ +([a-z_]+):.*/\"\1\"/'" units numbers table
make requirement "$requirement" units numbers toml
make solve "$requirement" units numbers toml
make motion "words crates/model/src/motion/read.rs" units numbers table
make rules "words crates/rules/src/*.rs crates/rules/src/registry/*.rs" units numbers toml "printf '\"%s\"\n' '\n== design.lock ==\n'"
make design "words crates/model/src/requirement/design_file.rs" "cut -d, -f1 catalogs/motors/*.csv | grep -oE '^[a-z0-9-]+' | sort -u | head -60 | sed 's/.*/\"&\"/'" units numbers toml
make study "words src/study/file.rs src/study/grid.rs crates/model/src/requirement/*.rs" units numbers toml
make urdf "words crates/model/src/mechanism/urdf.rs crates/model/src/mechanism/xml.rs" numbers xml
make mjcf "words crates/model/src/mechanism/mjcf/*.rs crates/model/src/mechanism/xml.rs" numbers xml
make bench "words crates/identify/src/read.rs crates/identify/src/read/*.rs crates/identify/src/bench.rs" units numbers toml
make log "words crates/identify/src/read/table.rs" numbers table
make mgdb "words crates/model/src/catalog/import/mgdb.rs crates/model/src/catalog/import/mgdb/*.rs" numbers table "printf '\"%s\"\n' '\n== a_gearboxes.csv ==\n' '\n== a_compatibility.csv ==\n'"

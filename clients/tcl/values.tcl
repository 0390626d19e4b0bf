# JSON and the values of Tcl. Structures are dictionaries. Arrays and sequences are dictionaries from 0:
# {0 1.5 1 2.5}, as in genomix. `null` is an empty string.

namespace eval genomix::values {}

# Returns the value of a JSON text.
proc genomix::values::read {text} {
    set position 0
    set value [ReadAt $text position]
    if {![regexp -start $position {\A\s*\Z} $text]} {
        error "text after the JSON value"
    }
    return $value
}

proc genomix::values::ReadAt {text at} {
    upvar 1 $at position
    set token [Token $text position]
    switch -- [string index $token 0] {
        "\{" - "\[" { return [ReadMembers $text position [string equal $token "\{"]] }
        "\"" { return [Unquoted $token] }
        "n" { return "" }
        "]" - "\}" - "," - ":" { error "unexpected `$token` in JSON" }
    }
    return $token
}

# Returns a dictionary with the members of an object, or the elements of an array by their numbers.
proc genomix::values::ReadMembers {text at named} {
    upvar 1 $at position
    set end [expr {$named ? "\}" : "\]"}]
    set members {}
    set before $position
    if {[Token $text position] eq $end} { return {} }
    set position $before
    while 1 {
        if {$named} {
            set key [Unquoted [Token $text position]]
            Token $text position
        } else {
            set key [dict size $members]
        }
        dict set members $key [ReadAt $text position]
        if {[Token $text position] ne ","} { return $members }
    }
}

proc genomix::values::Token {text at} {
    upvar 1 $at position
    set pattern {\A\s*("(?:[^"\\]|\\.)*"|[][{}:,]|-?\d[-+.eE\d]*|true|false|null)}
    if {![regexp -indices -start $position $pattern $text all token]} {
        error "invalid JSON at character $position"
    }
    set position [expr {[lindex $all 1] + 1}]
    return [string range $text {*}$token]
}

proc genomix::values::Unquoted {token} {
    set text [string range $token 1 end-1]
    if {[string first \\ $text] < 0} { return $text }
    set result ""
    set last 0
    foreach match [regexp -all -inline -indices {\\(?:u[0-9a-fA-F]{4}|.)} $text] {
        lassign $match from to
        append result [string range $text $last [expr {$from - 1}]]
        set escape [string range $text [expr {$from + 1}] $to]
        if {[string length $escape] == 5} {
            append result [format %c 0x[string range $escape 1 end]]
        } else {
            append result [string map {n \n t \t r \r b \b f \f} $escape]
        }
        set last [expr {$to + 1}]
    }
    return $result[string range $text $last end]
}

# Returns the JSON of a string, in ASCII.
proc genomix::values::quoted {text} {
    set result \"
    foreach character [split $text ""] {
        scan $character %c code
        if {$character in {\" \\}} {
            append result \\$character
        } elseif {$code >= 32 && $code < 127} {
            append result $character
        } elseif {$code > 0xffff} {
            incr code -0x10000
            append result [format \\u%04x [expr {0xd800 + ($code >> 10)}]]
            append result [format \\u%04x [expr {0xdc00 + ($code & 0x3ff)}]]
        } else {
            append result [format \\u%04x $code]
        }
    }
    return $result\"
}

# Returns the JSON of a value, as a JSON Schema wants it. `path` names the value in errors.
proc genomix::values::fitted {value schema path} {
    if {[dict exists $schema anyOf]} {
        set all [dict get $schema anyOf]
        if {$value eq "" && [dict get $all 1] eq {type null}} { return null }
        set schema [dict get $all 0]
    }
    if {![dict exists $schema type]} { return [Guessed $value] }
    set type [dict get $schema type]
    # A float has the types `number` and `null`.
    if {[dict exists $schema type 0]} { set type [dict get $schema type 0] }
    switch -- $type {
        object { return [FittedObject $value $schema $path] }
        array { return [FittedArray $value $schema $path] }
        string {
            if {![dict exists $schema enum]} { return [quoted $value] }
            if {[string is entier -strict $value]} { return [expr {entier($value)}] }
            # ::nhfc::tilt_prioritized is an enumerator, too.
            return [quoted [namespace tail $value]]
        }
        boolean {
            if {[string is boolean -strict $value]} { return [expr {$value ? "true" : "false"}] }
        }
        integer {
            if {[string is entier -strict $value]} { return [expr {entier($value)}] }
            if {[Finite $value] && $value == entier($value)} { return [expr {entier($value)}] }
        }
        number {
            if {[Finite $value]} { return [expr {double($value)}] }
        }
        null { return null }
    }
    Wrong "$path: `$value` is not [expr {$type eq "integer" ? "an" : "a"}] $type"
}

proc genomix::values::FittedObject {value schema path} {
    if {![IsDict $value]} { Wrong "$path: `$value` is not a dictionary by names" }
    set members {}
    dict for {name each} $value {
        set known {}
        if {[dict exists $schema properties $name]} { set known [dict get $schema properties $name] }
        lappend members [quoted $name]:[fitted $each $known $path.$name]
    }
    return "{[join $members ,]}"
}

proc genomix::values::FittedArray {value schema path} {
    if {![IsDict $value]} { Wrong "$path: `$value` is not an array: write {0 VALUE 1 VALUE}" }
    set elements {}
    for {set index 0} {$index < [dict size $value]} {incr index} {
        if {![dict exists $value $index]} {
            Wrong "$path: element $index is missing: write {0 VALUE 1 VALUE}"
        }
        lappend elements [fitted [dict get $value $index] [dict get $schema items] "$path\[$index\]"]
    }
    return "\[[join $elements ,]]"
}

# The JSON of a value whose type the run does not know.
proc genomix::values::Guessed {value} {
    if {[string is entier -strict $value]} { return [expr {entier($value)}] }
    if {[Finite $value]} { return [expr {double($value)}] }
    if {$value in {true false}} { return $value }
    return [quoted $value]
}

proc genomix::values::Finite {value} {
    expr {[string is double -strict $value] && $value == $value && abs($value) < Inf}
}

# True if a value is a dictionary without a repeated name.
proc genomix::values::IsDict {value} {
    expr {![catch {dict size $value} size] && 2 * $size == [llength $value]}
}

proc genomix::values::Wrong {message} {
    return -code error -errorcode {DOTGEN WRONG} $message
}

# Tests of the package against a run of cli/tests/hosted/echo.gen. Started by tests/editors/client/test_tcl.py.

package require tcltest
namespace import tcltest::*
lappend auto_path [file dirname [file dirname [file normalize [info script]]]]
package require genomix

set g [genomix connect]
$g rpath /opt/openrobots/lib/genom/pocolibs/plugins
$g load /opt/openrobots/lib/genom/pocolibs/plugins/echo.so

# Returns the message of an error and its code.
proc failed {script} {
    if {![catch {uplevel 1 $script} message options]} { return "no error: $message" }
    return [list $message [dict get $options -errorcode]]
}

test call {inputs in order, by name, with defaults} -body {
    list [echo::count 4] [::echo::count {n 3}] [echo::count] [echo::count -w -- 1]
} -result {{seen 4} {seen 3} {seen 2} {seen 1}}

test attribute {what is set is read} -body {
    echo::set_gain {gain 5}
    echo::get_gain
} -result {gain 5}

test exception {the code has the exception and its members} -body {
    list [failed {echo::fail 3}] [failed {echo::set_gain -- -1}]
} -result [list \
    {{::echo::e_bad {code 3}} {GENOM ::echo::e_bad {code 3}}} \
    {::echo::e_plain {GENOM ::echo::e_plain {}}}]

test background {& returns a request} -body {
    set request [echo::count 1000000 &]
    set before [list [$request status] [$request service] [failed {$request result}]]
    # An activity that is interrupted before its first codel fails.
    $request abort
    catch {$request wait 60} end
    catch {$request result} result
    list $before [regexp {^(seen -?\d+|::genom::interrupted)$} $end] [string equal $result $end]
} -result {{sent echo.count {{echo.count has not ended: use `wait`} {DOTGEN BUSY}}} 1 1}

test callback {words after & are called with the request} -body {
    proc ended {word request} { set ::ended "$word [$request result]" }
    echo::count 3 & ended counted
    vwait ended
    set ended
} -result {counted seen 3}

test send {-send, -ack, -oneway} -body {
    set failing [echo::fail -s 1]
    set counting [echo::count -a 1000000]
    set nothing [echo::count -oneway 1]
    catch {$failing wait}
    set statuses [list [$failing status] [$counting status] $nothing]
    $counting abort
    lappend statuses [failed {echo::fail -ack 2}]
} -result {error sent {} {{::echo::e_bad {code 2}} {GENOM ::echo::e_bad {code 2}}}}

test timeout {the service goes on} -body {
    list [failed {echo::count -timeout 0.05 1000000}] [echo::count 1]
} -result {{{echo.count did not answer within 0.05 s} {DOTGEN TIMEOUT}} {seen 1}}

test kept {old requests are forgotten, also refused ones} -body {
    set kept $genomix::KEPT
    set genomix::KEPT 1
    foreach code {1 2 3} { catch {echo::fail -ack $code} }
    set seen [[echo::count 1 &] wait]
    set genomix::KEPT $kept
    set seen
} -result {seen 1}

test port {the newest data of a port, and of an instance} -body {
    list [dict keys [dict get [echo::trail] trail 0]] [dict get [echo::each a] each] [failed {echo::each b}]
} -result {{x y} 50 {{`echo/each` has no instance `b`} {DOTGEN WRONG}}}

test values {all types come back} -body {
    set text "\u00e9 \"q\" \\ \{ \n"
    set given [dict create b yes o 7 s 3.0 ul 4000000000 ll -9007199254740993 f .5 name short c ::m::BLUE \
        grid {0 {0 {x 1 y 2} 1 {x 3}} 1 {0 {} 1 {y 4}}} few {0 {x 5 y 6}} deep {0 {0 1 1 2} 1 {}} \
        maybe {x 7 y 8} kind {_d GREEN centre {x 9 y 0}} bits {0 1 1 off} text $text words {0 a 1 {b c}}]
    set back [dict get [echo::mirror [list given $given]] back]
    list [dict get $back text] [dict remove $back text] [dict get [echo::mirror] back maybe]
} -result [list "\u00e9 \"q\" \\ \{ \n" {b true o 7 s 3 ul 4000000000 ll -9007199254740993 f 0.5 name short c BLUE\
    grid {0 {0 {x 1.0 y 2.0} 1 {x 3.0 y 0.0}} 1 {0 {x 0.0 y 0.0} 1 {x 0.0 y 4.0}}} few {0 {x 5.0 y 6.0}}\
    deep {0 {0 1 1 2} 1 {}} maybe {x 7.0 y 8.0} kind {_d GREEN centre {x 9.0 y 0.0}} bits {0 true 1 false}\
    words {0 a 1 {b c}}} {}]

test wrong {errors name the value} -body {
    foreach script {
        {echo::count many} {echo::count 1 2} {echo::mirror {given {few {1 {}}}}} {echo::mirror {given {deep 1}}}
        {echo::mirror {given {nobody 1}}} {echo::count -later 1} {echo::count -timeout soon 1} {$::g load nobody} {genomix::connect far:8080}
    } {
        lassign [failed $script] message code
        lappend messages $message
        lappend codes $code
    }
    list [lsort -unique $codes] [join $messages \n]
} -match glob -result {{{DOTGEN WRONG}} {echo.count.n: `many` is not an integer
echo.count has 1 inputs: n
echo.mirror.given.few: element 0 is missing: write {0 VALUE 1 VALUE}
echo.mirror.given.deep: `1` is not an array: write {0 VALUE 1 VALUE}
`echo.mirror`: `given.nobody` is not a member*
echo.count: bad flag "-later"*
echo.count: -timeout needs a number of seconds
no component `nobody` in this run; there are: echo
`far:8080` is not `localhost:PORT`: other machines cannot be reached}}

test help {-h describes a service} -body {
    echo::count -h
} -result "echo.count: activity\n  n = 2\noutputs: seen"

test json {what is not JSON is refused} -body {
    lmap text {{[1,2} {{"a":1} 1 2} {"\u0041\n"} nul} { catch {genomix::values::read $text} value; set value }
} -result {{invalid JSON at character 4} {text after the JSON value} {A
} {invalid JSON at character 0}}

test close {open requests fail} -body {
    set request [echo::count 1000000 &]
    $g close
    list [$request status] [failed {$request wait}] [failed {echo::count 1}]
} -result {error {{the run has ended} {DOTGEN LOST}} {{the run has ended} {DOTGEN LOST}}}

set failures $tcltest::numTests(Failed)
cleanupTests
exit [expr {$failures > 0}]

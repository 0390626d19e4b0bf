# Runs Tcl scripts of genomix against `dotgen run --clock real --listen PORT`. See docs/tcl.md.

package require Tcl 8.6-
package provide genomix 1.0

namespace eval genomix {
    namespace export connect localhost
    namespace ensemble create

    # By name of a connection: its channel and the components of the run.
    variable channels {}
    variable components {}
    # By number: a request that has not been forgotten.
    variable requests
    array set requests {}
    variable count 0
    variable connected 0
    # Ended requests in the background. The oldest beyond `KEPT` are forgotten.
    variable ended {}
    variable KEPT 1000
    # Milliseconds in which a run answers what it answers at once.
    variable SILENT 5000
    # Characters of a line that has not ended.
    variable LONGEST 67108864
    # Changes with each answer.
    variable news 0
}

# Connects to a run on this machine. Returns a handle: genomix1, genomix2, …
proc genomix::connect {{address localhost:8080}} {
    variable channels
    variable components
    variable connected
    lassign [Port $address] port token
    if {[catch {socket 127.0.0.1 $port} channel]} {
        Fail LOST "no run at localhost:$port ($channel): start `dotgen run --clock real --listen $port FILE`"
    }
    fconfigure $channel -blocking 0 -buffering line -encoding utf-8 -translation lf
    set handle genomix[incr connected]
    dict set channels $handle $channel
    fileevent $channel readable [list genomix::Receive $handle]
    if {[catch {
        if {$token ne ""} { puts $channel "{\"token\":[values::quoted $token]}" }
        set answer [Ask $handle {"describe":null} description]
    } message options]} {
        Lose $handle
        return -options $options $message
    }
    set found {}
    dict for {_ component} [dict get $answer components] {
        dict set found [dict get $component name] $component
    }
    dict set components $handle $found
    interp alias {} ::$handle {} genomix::Handle $handle
    return $handle
}

# Connects to the run on this machine.
proc genomix::localhost {args} { connect }

# Returns the TCP port of a run, and its token. A token at another port is used if it is the only one.
proc genomix::Port {address} {
    if {![regexp {^(localhost|127\.0\.0\.1)?(?::?(\d{1,5}))?$} $address _ host port]} {
        Fail WRONG "`$address` is not `localhost:PORT`: other machines cannot be reached"
    }
    if {$port eq ""} { set port 8080 }
    set folder [Folder]
    set tokens [lsort [glob -nocomplain -tails -directory $folder *.token]]
    if {"$port.token" ni $tokens} {
        if {[llength $tokens] > 1} {
            set ports [lmap name $tokens { file rootname $name }]
            Fail WRONG "no run at localhost:$port; there are runs at the ports [join $ports {, }]"
        }
        if {$tokens eq ""} { return [list $port ""] }
        set port [file rootname [lindex $tokens 0]]
    }
    set file [open [file join $folder $port.token]]
    set token [string trim [read $file 1000]]
    close $file
    return [list $port $token]
}

# Returns the folder of the sockets and tokens of this user.
proc genomix::Folder {} {
    global env
    if {[info exists env(XDG_RUNTIME_DIR)] && $env(XDG_RUNTIME_DIR) ne ""} {
        return [file join $env(XDG_RUNTIME_DIR) dotgen]
    }
    set above [expr {[info exists env(TMPDIR)] ? $env(TMPDIR) : "/tmp"}]
    return [file join $above dotgen-[exec id -u]]
}

# The subcommands of a connection.
proc genomix::Handle {handle command args} {
    variable components
    switch -- $command {
        load { return [Load $handle {*}$args] }
        rpath - unload { return }
        close - disconnect { Lose $handle; return }
        components { return [dict keys [dict get $components $handle]] }
    }
    Fail WRONG "unknown subcommand `$command`: must be load, rpath, unload, components or close"
}

# Creates a command for each service and output port of a component: ::pump::fill, ::pump::level.
proc genomix::Load {handle plugin args} {
    variable components
    set name [file rootname [file tail $plugin]]
    set named [lsearch -exact $args -i]
    if {$named >= 0 && $named + 1 < [llength $args]} { set name [lindex $args $named+1] }
    set known [dict get $components $handle]
    if {![dict exists $known $name]} {
        Fail WRONG "no component `$name` in this run; there are: [join [dict keys $known] {, }]"
    }
    if {$name in {genomix tcl oo}} { Fail WRONG "`::$name` is a namespace of Tcl: rename the component" }
    namespace eval ::$name {}
    set description [dict get $known $name]
    dict for {_ port} [dict get $description ports] {
        set own [dict get $port name]
        if {[dict get $port direction] eq "out"} {
            interp alias {} ::${name}::$own {} genomix::Read $handle $name $own
        }
    }
    dict for {_ service} [dict get $description services] {
        interp alias {} ::${name}::[dict get $service name] {} genomix::Call $handle $name $service
    }
    return $name
}

# Returns the newest data of an output port: {level 1.5}.
proc genomix::Read {handle component port {instance ""}} {
    set answer [Ask $handle "\"read\":[values::quoted $component/$port]" data]
    if {$instance eq ""} { return [list $port [dict get $answer value]] }
    if {![dict exists $answer instances $instance]} {
        Fail WRONG "`$component/$port` has no instance `$instance`"
    }
    return [list $port [dict get $answer instances $instance]]
}

# Calls a service: ?-ack|-send|-oneway|-wait|-help? ?-timeout SECONDS? ?--? ?INPUTS? ?& ?CALLBACK??
proc genomix::Call {handle component service args} {
    variable requests
    set path $component.[dict get $service name]
    set mode -wait
    set timeout ""
    set callback {}
    while {[string match {-[a-z-]*} [lindex $args 0]]} {
        set args [lassign $args flag]
        if {$flag eq "--"} break
        set flags {-ack -help -oneway -send -timeout -wait}
        if {[catch {tcl::prefix match -message flag $flags $flag} flag]} { Fail WRONG "$path: $flag" }
        if {$flag ne "-timeout"} { set mode $flag; continue }
        set args [lassign $args timeout]
        if {![string is double -strict $timeout] || $timeout <= 0} {
            Fail WRONG "$path: -timeout needs a number of seconds"
        }
    }
    if {$mode eq "-help"} { return [Help $path $service] }
    set background [lsearch -exact $args &]
    if {$background >= 0} {
        set mode -send
        set callback [lrange $args $background+1 end]
        set args [lrange $args 0 $background-1]
    }
    set input [Inputs $path [dict get $service inputs] $args]
    set number [Send $handle "\"call\":[values::quoted $path],\"input\":$input" $path]
    dict set requests($number) callback $callback
    if {$mode in {-ack -send}} { dict set requests($number) keep hold }
    switch -- $mode {
        -oneway { dict set requests($number) keep drop; return }
        -ack { return [Accepted $number $timeout] }
        -send { return [Request $number] }
    }
    set code [catch {Wait $number $timeout} result options]
    if {[dict exists $requests($number) answer]} { unset requests($number) } else {
        dict set requests($number) keep drop
    }
    return -options $options $result
}

# Returns the JSON of the inputs, given in order or as one dictionary by names.
proc genomix::Inputs {path inputs values} {
    set schemas {}
    dict for {_ input} $inputs { dict set schemas [dict get $input name] [dict get $input schema] }
    set names [dict keys $schemas]
    if {[llength $values] == 1 && [ByName $schemas [lindex $values 0]]} {
        set given [lindex $values 0]
    } elseif {[llength $values] > [llength $names]} {
        Fail WRONG "$path has [llength $names] inputs: [join $names {, }]"
    } else {
        set given {}
        foreach name $names value $values {
            if {[dict size $given] < [llength $values]} { dict set given $name $value }
        }
    }
    return [values::fitted $given [list type object properties $schemas] $path]
}

# True if a value is a dictionary of inputs. An empty one is, unless the only input is a string.
proc genomix::ByName {schemas value} {
    if {![values::IsDict $value]} { return 0 }
    if {$value eq ""} {
        set types [lmap schema [dict values $schemas] { dict get [dict merge {type any} $schema] type }]
        return [expr {$types ne "string"}]
    }
    # With several inputs, one known name is enough: the run says which name is wrong.
    set known 0
    foreach name [dict keys $value] { incr known [dict exists $schemas $name] }
    return [expr {$known == [dict size $value] || ($known > 0 && [dict size $schemas] > 1)}]
}

proc genomix::Help {path service} {
    set lines [list "$path: [dict get $service kind]"]
    if {[dict get $service doc] ne ""} { lappend lines [dict get $service doc] }
    dict for {_ input} [dict get $service inputs] {
        set line "  [dict get $input name]"
        foreach member {default description unit} around {{ = %s} {: %s} { (%s)}} {
            if {[dict exists $input schema $member]} {
                append line [format $around [dict get $input schema $member]]
            }
        }
        lappend lines $line
    }
    set outputs [dict values [dict get $service outputs]]
    lappend lines "outputs: [expr {$outputs eq "" ? "none" : [join $outputs {, }]}]"
    return [join $lines \n]
}

# Creates the command of a request, which scripts hold.
proc genomix::Request {number} {
    interp alias {} ::genomix::request$number {} genomix::OfRequest $number
    return ::genomix::request$number
}

# The subcommands of a request.
proc genomix::OfRequest {number command args} {
    variable requests
    set handle [dict get $requests($number) handle]
    Receive $handle
    switch -- $command {
        status { return [dict get $requests($number) status] }
        result {
            if {![dict exists $requests($number) answer]} {
                Fail BUSY "[dict get $requests($number) path] has not ended: use `wait`"
            }
            return [Wait $number ""]
        }
        wait { return [Wait $number [lindex $args 0]] }
        service { return [dict get $requests($number) path] }
        abort {
            if {![dict exists $requests($number) answer]} {
                set abort [Send $handle "\"abort\":$number" abort]
                dict set requests($abort) keep drop
            }
            return
        }
    }
    Fail WRONG "unknown subcommand `$command`: must be status, result, wait, abort or service"
}

# Waits until a service is accepted. Returns its request.
proc genomix::Accepted {number timeout} {
    variable requests
    Until {[dict get $requests($number) accepted] || [dict exists $requests($number) answer]} $number $timeout
    if {[dict get $requests($number) status] eq "error"} { return [Wait $number ""] }
    return [Request $number]
}

# Waits for the end of a service. Returns its outputs by name, or fails with its exception.
proc genomix::Wait {number timeout} {
    variable requests
    Until {[dict exists $requests($number) answer]} $number $timeout
    set answer [dict get $requests($number) answer]
    switch -- [dict get $answer event] {
        done { return [dict get $answer output] }
        failed {
            set exception [dict get $answer exception]
            set detail [expr {[dict exists $answer detail] ? [dict get $answer detail] : ""}]
            set message [expr {$detail eq "" ? $exception : "$exception {$detail}"}]
            return -code error -errorcode [list GENOM $exception $detail] $message
        }
        lost { Fail LOST "the run has ended" }
    }
    Fail WRONG [dict get $answer message]
}

# Executes events until a condition about a request holds. An empty timeout has no limit.
proc genomix::Until {condition number timeout} {
    variable requests
    variable news
    set timer ""
    if {$timeout ne ""} {
        set end [expr {[clock milliseconds] + round(1000 * $timeout)}]
        set timer [after [expr {max(1, round(1000 * $timeout))}] {incr genomix::news}]
    }
    while {![expr $condition]} {
        if {$timer ne "" && [clock milliseconds] >= $end} {
            Fail TIMEOUT "[dict get $requests($number) path] did not answer within $timeout s"
        }
        vwait genomix::news
    }
    after cancel $timer
}

# Sends a request, and returns the answer with an event. Fails after `SILENT` milliseconds.
proc genomix::Ask {handle members event} {
    variable requests
    variable SILENT
    set number [Send $handle $members "the run"]
    try {
        Until {[dict exists $requests($number) answer]} $number [expr {$SILENT / 1000.0}]
        set answer [dict get $requests($number) answer]
        if {[dict get $answer event] ne $event} { Wait $number "" }
        return $answer
    } finally {
        unset requests($number)
    }
}

proc genomix::Send {handle members path} {
    variable channels
    variable requests
    variable count
    if {![dict exists $channels $handle]} { Fail LOST "the run has ended" }
    set number [incr count]
    set requests($number) [dict create handle $handle path $path status sent accepted 0 callback {} keep wait]
    puts [dict get $channels $handle] "{\"id\":$number,$members}"
    return $number
}

# Reads the lines that have come.
proc genomix::Receive {handle} {
    variable channels
    variable LONGEST
    if {![dict exists $channels $handle]} return
    set channel [dict get $channels $handle]
    while {![catch {gets $channel line} length] && $length >= 0} {
        # What answers anything else is not a run.
        if {[catch {dict get [set answer [values::read $line]] id}]} { return [Lose $handle] }
        Answered $answer
    }
    if {$length ni {-1} || [eof $channel] || [chan pending input $channel] > $LONGEST} { Lose $handle }
}

proc genomix::Answered {answer} {
    variable requests
    variable news
    incr news
    set number [dict get $answer id]
    if {![info exists requests($number)]} return
    switch -- [dict get $answer event] {
        accepted { dict set requests($number) accepted 1; return }
        done { set status done }
        failed - error - lost { set status error }
        default { set status done }
    }
    dict set requests($number) status $status
    dict set requests($number) answer $answer
    Ended $number
}

# Calls the callback of a request that has ended, and forgets old requests.
proc genomix::Ended {number} {
    variable requests
    variable ended
    variable KEPT
    switch -- [dict get $requests($number) keep] {
        drop { unset requests($number); return }
        wait return
    }
    set callback [dict get $requests($number) callback]
    if {$callback ne ""} { after 0 [list {*}$callback [Request $number]] }
    lappend ended $number
    if {[llength $ended] > $KEPT} {
        set ended [lassign $ended oldest]
        unset -nocomplain requests($oldest)
        # A request that was refused has no command.
        catch {interp alias {} ::genomix::request$oldest {}}
    }
}

# Ends a connection. Its open requests fail; activities go on.
proc genomix::Lose {handle} {
    variable channels
    variable requests
    variable news
    if {![dict exists $channels $handle]} return
    catch {close [dict get $channels $handle]}
    dict unset channels $handle
    foreach number [array names requests] {
        if {[dict get $requests($number) handle] ne $handle} continue
        if {![dict exists $requests($number) answer]} {
            Answered [dict create id $number event lost]
        }
    }
    incr news
}

proc genomix::Fail {kind message} {
    return -code error -errorcode [list DOTGEN $kind] $message
}

# The Tcl side of the template engine. It runs in the interpreter of a tclsh process; templates run
# in two others: "main" runs template.tcl, and the safe interpreter "slave" inside it runs the
# sources. What they can call beyond Tcl is asked from the engine at the other end of the standard
# channels. Messages are words with their lengths in front; the engine answers each question once,
# and may ask to evaluate a script before it does.

namespace eval ::dg {
  variable lang c
  variable slave {main slave}
  variable status 2
  variable text {}
  variable limit 0
  variable pending [dict create]
  array set answers {}
  array set refusals {}
}

proc ::dg::send {args} {
  variable request
  set head [llength $args]
  set body {}
  foreach word $args {
    set bytes [encoding convertto utf-8 $word]
    append head { } [string length $bytes]
    append body $bytes
  }
  puts -nonewline $request $head\n$body
  flush $request
}

proc ::dg::receive {} {
  variable reply
  if {[gets $reply head] < 0} { ::dg::leave 1 }
  set words {}
  foreach length $head { lappend words [read $reply $length] }
  return $words
}

# Asks the engine. The answer is a code, a text, whether it stays true, and other answers that come
# with it.
proc ::dg::ask {args} {
  send {*}$args
  while 1 {
    lassign [receive] code text pure more
    if {$code eq "bytes"} { return $text }
    set text [encoding convertfrom utf-8 $text]
    switch -- $code {
      ok { return $text }
      error { return -code error $text }
      fatal { return -code error -errorcode {DOTGEN FATAL} $text }
      eval {
        set code [catch {interp eval main [list uplevel #0 $text]} result]
        send return $code $result
      }
    }
  }
}

# The same for questions whose answers are kept.
proc ::dg::query {args} {
  variable answers
  variable refusals
  variable lang
  set key $lang,$args
  if {[info exists answers($key)]} { return $answers($key) }
  if {[info exists refusals($key)]} { return -code error $refusals($key) }
  send query $lang {*}$args
  while 1 {
    lassign [receive] code text pure more
    set text [encoding convertfrom utf-8 $text]
    switch -- $code {
      ok {
        if {$more ne {}} {
          set handle [lindex $args 1]
          foreach {method good answer} [encoding convertfrom utf-8 $more] {
            set other [list object $handle $method]
            if {$good} {
              set answers($lang,$other) $answer
            } else {
              set refusals($lang,$other) $answer
            }
          }
        }
        if {$pure} { set answers($key) $text }
        return $text
      }
      error {
        if {$pure} { set refusals($key) $text }
        return -code error $text
      }
      fatal { return -code error -errorcode {DOTGEN FATAL} $text }
      eval {
        set code [catch {interp eval main [list uplevel #0 $text]} result]
        send return $code $result
      }
    }
  }
}

proc ::dg::forget {} {
  variable answers
  variable refusals
  array unset answers
  array unset refusals
}

# --- errors -------------------------------------------------------------------------------------

# Commands of template.tcl that are running, innermost first, as lines of a message.
proc ::dg::callers {skip} {
  variable dir
  set lines {}
  set depth [interp eval main {info frame}]
  for {set i [expr {$depth - 1}]} {$i > 0} {incr i -1} {
    set frame [interp eval main [list info frame $i]]
    if {![dict exists $frame file] || ![dict exists $frame line]} continue
    if {[incr skip -1] >= 0} continue
    set file [dict get $frame file]
    if {[string match $dir/* $file]} { set file [file tail $file] }
    append lines "\n called by: $file:[dict get $frame line] [first_line [dict get $frame cmd]]"
  }
  return $lines
}

proc ::dg::first_line {command} {
  set line [lindex [split $command \n] 0]
  if {[string length $line] > 40} { set line [string range $line 0 40]... }
  return $line
}

# Ends every level of the main interpreter with an error.
proc ::dg::fatal {message {skip 0}} {
  set level [interp eval main {info level}]
  return -code error -level [expr {$level + 3}] $message[callers $skip]
}

# For procedures whose failures end every level.
proc ::dg::strict {args} {
  if {[catch $args result options]} {
    if {[dict get $options -errorcode] eq {DOTGEN FATAL}} {
      set level [interp eval main {info level}]
      return -code error -level [expr {$level + 2}] $result[callers 0]
    }
    return -code error $result
  }
  return $result
}

proc ::dg::wrong_args {usage} {
  return -code error -level 2 "wrong # args: should be \"$usage\""
}

# --- objects and languages ----------------------------------------------------------------------

proc ::dg::object {handle args} {
  if {[catch {query object $handle {*}$args} result options]} {
    if {[dict get $options -errorcode] eq {DOTGEN FATAL}} { append result [callers 0] }
    return -code error $result
  }
  return $result
}

proc ::dg::lang {args} {
  variable lang
  if {[llength $args] != 1} { wrong_args "lang language" }
  set known {c c c++ c++ tcl tcl}
  if {![dict exists $known [lindex $args 0]]} { fatal "unsupported language [lindex $args 0]" }
  set lang [dict get $known [lindex $args 0]]
  return ::language::$lang
}

proc ::dg::parse {args} {
  variable slave
  if {[llength $args] < 2} { wrong_args "dotgen parse file|string data ?...?" }
  set code [catch {ask parse {*}$args} created]
  forget
  if {$code} { return -code error $created }
  foreach handle $created {
    interp alias main $handle {} ::dg::object $handle
    interp alias $slave $handle {} ::dg::object $handle
  }
  return
}

# --- template -----------------------------------------------------------------------------------

proc ::dg::template_options {args} {
  variable options
  variable parsed
  if {[llength $args] != 1} { wrong_args "template options ospec" }
  lassign $args spec
  if {$parsed} {
    fatal "options specification must be set before any 'template parse' command"
  }
  if {[llength $spec] % 2} { fatal "invalid options specification" }
  set options [list {*}$spec -h - --help {template fatal "help not implemented"}]
  get_options
}

# Parses the options once. A word written -x=y counts as two, which may leave options unread.
proc ::dg::get_options {} {
  variable options
  variable parsed
  if {$parsed} return
  set parsed 1
  while {[interp eval main {set ::argc}] > 0} {
    set argument [lindex [interp eval main {set ::argv}] 0]
    if {[regexp -- {(--?.+)=(.+)} $argument - argument value]} {
      interp eval main [list set ::argv [linsert [interp eval main {set ::argv}] 1 $value]]
    }
    set unknown [list template fatal "unknown option $argument"]
    set bodies [list {*}$options -* $unknown * {error {} {} {DOTGEN STOP}}]
    set code [catch {
      interp eval main [list uplevel #0 [list switch -glob -- $argument $bodies]]
    } result info]
    if {$code == 3} return
    if {$code == 1 && [dict get $info -errorcode] eq {DOTGEN STOP}} return
    if {$code == 1 || $code == 2} {
      dict incr info -level
      return -options $info $result
    }
    interp eval main {
      incr ::argc -1
      set ::argv [lrange $::argv 1 end]
    }
  }
}

proc ::dg::template_arg {args} {
  if {[llength $args] > 1} { wrong_args "template arg ?opt?" }
  switch -- [set what [lindex [list {*}$args next] 0]] {
    next { return [next_argument] }
    files - names { return [dict get [split_arguments] $what] }
    components { return [named_components] }
  }
  fatal "unknown command '$what':  must be next, files, names or components"
}

# The arguments that are files, and the others, which are names. Without any file the first one is taken for one, so
# that reading it tells that it is not there.
proc ::dg::split_arguments {} {
  set files {}
  set names {}
  set path [interp eval main {dotgen input path}]
  foreach argument [interp eval main {set ::argv}] {
    if {[file isfile [file join $path $argument]]} {
      lappend files $argument
    } else {
      lappend names $argument
    }
  }
  if {![llength $files]} { set names [lassign $names files] }
  return [dict create files $files names $names]
}

# The components and interfaces that the arguments name; without names those that the files themselves define.
proc ::dg::named_components {} {
  set arguments [split_arguments]
  set found {}
  foreach name [dict get $arguments names] {
    set objects [interp eval main [list dotgen components $name]]
    lappend objects {*}[interp eval main [list dotgen interfaces $name]]
    if {![llength $objects]} { fatal "no such object $name." }
    # One element for each name, as templates expect it.
    lappend found $objects
  }
  if {[llength $found]} { return $found }
  set path [interp eval main {dotgen input path}]
  set inputs {}
  foreach name [dict get $arguments files] {
    file stat [file join $path $name] status
    lappend inputs $status(dev)+$status(ino)
  }
  foreach object [interp eval main {concat [dotgen components] [dotgen interfaces]}] {
    set name [interp eval main [list $object loc file]]
    if {![file exists $name]} continue
    file stat $name status
    if {"$status(dev)+$status(ino)" in $inputs} { lappend found $object }
  }
  return $found
}

proc ::dg::next_argument {} {
  set argv [interp eval main {set ::argv}]
  set value [lindex $argv 1]
  if {$value eq {}} { fatal "missing argument to [lindex $argv 0]" }
  interp eval main [list set ::argv [lreplace $argv 1 1]]
  interp eval main {incr ::argc -1}
  return $value
}

proc ::dg::template_usage {args} {
  variable usage
  if {![llength $args]} { return $usage }
  set usage [join $args {}]
  return
}

proc ::dg::template_fatal {args} {
  set skip 1
  if {[string match -* [lindex $args 0]]} {
    set args [lassign $args count]
    incr skip [expr {-$count}]
  }
  set level [interp eval main {info level}]
  return -code error -level [expr {$level + 2}] [join $args][callers $skip]
}

proc ::dg::template_message {args} {
  if {[llength $args] != 1} { wrong_args "template message m" }
  ask message [lindex $args 0]
  return
}

proc ::dg::template_deps {args} {
  if {[llength $args]} { wrong_args "template deps" }
  return [ask deps]
}

proc ::dg::template_require {args} {
  variable dir
  variable slave
  if {[llength $args] != 1} { wrong_args "template require src" }
  lassign $args source
  set path [file join $dir $source]
  ask message "sourcing $path"
  if {[catch {
    interp eval main [list uplevel #0 [list source -encoding utf-8 $path]]
    interp invokehidden $slave -global source -encoding utf-8 $path
  } message info]} {
    set line 1
    regexp "\\(file \"[regsub -all {\W} $path {\\&}]\" line (\\d+)\\)" \
        [dict get $info -errorinfo] - line
    return -code error "$source:$line $message[callers 0]"
  }
  ask dep $path
  return
}

# Expands sources, one after the other, into a file or a variable.
proc ::dg::template_parse {args} {
  variable slave
  variable text
  if {[llength $args] < 4 || [llength $args] % 2} { fatal "wrong # args" }
  get_options
  set permissions {}
  lassign [lrange $args end-1 end] kind target
  switch -- $kind {
    file {}
    string { interp eval main [list set ::$target {}] }
    default { fatal "invalid channel type $kind: must be file or string" }
  }
  set text {}
  set saved [source_arguments {}]
  foreach {what source} [lrange $args 0 end-2] {
    switch -- $what {
      args { source_arguments $source }
      perm { set permissions $source }
      raw { append text [binary format a* $source] }
      string { expand string $source <string> }
      file { expand file $source $source }
      default {
        finish $kind $target {}
        fatal "unknown source '$what': must be args, string or file"
      }
    }
  }
  source_arguments $saved
  finish $kind $target $permissions
  return
}

proc ::dg::finish {kind target permissions} {
  variable text
  set result $text
  set text {}
  if {$kind eq "file"} {
    ask commit $target $permissions $result
  } else {
    interp eval main [list set ::$target [binary format a* $result]]
  }
}

# Sets argc and argv of the sources; returns the arguments before.
proc ::dg::source_arguments {arguments} {
  variable slave
  if {[catch {interp eval $slave {set ::argv}} before]} { set before {} }
  interp eval $slave [list set ::argc [llength $arguments]]
  interp eval $slave [list set ::argv $arguments]
  return $before
}

# Runs a translated source; what it prints is added to the text.
proc ::dg::expand {kind source name} {
  variable slave
  set program [ask marker $kind $source]
  interp alias $slave puts {} ::dg::collect
  interp eval $slave [list set "\1trace" {}]
  set code [catch {
    interp invokehidden $slave -global source -encoding utf-8 $program
  } message info]
  interp alias $slave puts {} ::dg::puts_elsewhere
  if {!$code} {
    ask done_source $program
    return
  }
  if {[dict exists $info -errorinfo]} {
    set trace [dict get $info -errorinfo]
  } else {
    set trace {}
  }
  return -code error [ask blame $name $program $message $trace \
      [interp eval $slave [list set "\1trace"]]]
}

# puts of a source: without a channel the text is output of the template.
proc ::dg::collect {args} {
  variable text
  variable limit
  if {[lindex $args 0] eq "-nonewline"} {
    set args [lrange $args 1 end]
    set end {}
  } else {
    set end \n
  }
  if {[llength $args] != 1} { return [puts_elsewhere {*}$args] }
  append text [lindex $args 0] $end
  if {$limit && [string length $text] > $limit} {
    ask too_much [string length $text]
  }
  return
}

proc ::dg::puts_elsewhere {args} {
  variable slave
  interp invokehidden $slave puts {*}$args
}

# --- engine -------------------------------------------------------------------------------------

proc ::dg::engine_open {args} {
  variable dir
  variable pending
  if {[llength $args] != 3} { wrong_args "engine::open type dst mode" }
  lassign $args kind target mode
  switch -- $kind/$mode {
    file/read { set path [file join $dir $target]; set access r }
    file/write { set path [ask engine mktemp]; set access w }
    default { fatal "invalid channel type $kind: must be file or string" }
  }
  set channel [interp eval main [list open $path $access]]
  interp eval main [list fconfigure $channel -encoding utf-8]
  if {$mode eq "write"} { dict set pending $channel [list $path $target] }
  return $channel
}

proc ::dg::engine_close {channel {permissions {}}} {
  variable pending
  interp eval main [list close $channel]
  if {![dict exists $pending $channel]} return
  lassign [dict get $pending $channel] path target
  dict unset pending $channel
  ask commit_file $target $permissions $path
  return
}

# --- interpreters -------------------------------------------------------------------------------

proc ::dg::input_channel {command channel args} {
  switch -- $command {
    initialize { return {initialize finalize watch read} }
    read { return [ask stdin [lindex $args 0]] }
  }
}

proc ::dg::output_channel {command channel args} {
  switch -- $command {
    initialize { return {initialize finalize watch write} }
    write {
      variable request
      set bytes [lindex $args 0]
      puts -nonewline $request "2 3 [string length $bytes]\nout$bytes"
      flush $request
      return [string length $bytes]
    }
  }
}

proc ::dg::exit_template {args} {
  variable status
  if {[llength $args] > 1} { wrong_args "exit ?returnCode?" }
  set value [expr {[llength $args] ? [lindex $args 0] : 0}]
  if {![string is integer -strict $value]} {
    return -code error "expected integer but got \"$value\"exit $value"
  }
  set status $value
  return -code error "exit $value"
}

# Prints a text on a line after the current number of blanks; in both interpreters.
set ::dg::indent {args {
  global _ilevel
  foreach word $args {
    switch -glob -- $word {
      #* {
        set _ilevel [string range $word 1 end]
        if {![string is digit $_ilevel]} { error "bad indentation \"#$_ilevel\"" }
      }
      ++ { incr _ilevel 2 }
      -- { incr _ilevel -2 }
      default {
        if {[catch {string repeat { } $_ilevel} blanks]} { set blanks {} }
        puts $blanks$word
      }
    }
  }
}}

# Makes an ensemble of commands that are aliases of commands here. An interpreter gets ensembles of
# its own: Tcl 8.6 fails on an abbreviation that reaches an ensemble through an alias.
proc ::dg::ensemble {paths name commands} {
  foreach path $paths {
    interp eval $path [list namespace eval $name {}]
    foreach {command target} $commands {
      interp alias $path ${name}::$command {} {*}$target
    }
    interp eval $path [list namespace eval $name [list namespace export {*}[dict keys $commands]]]
    interp eval $path [list namespace eval $name {namespace ensemble create}]
  }
}

proc ::dg::populate {} {
  variable slave
  variable indent
  set both [list main $slave]
  interp eval main {namespace eval ::dotgen::object {}}
  interp eval $slave {namespace eval ::dotgen::object {}}
  foreach {group members} {
    genom {program cmdline version templates debug verbose}
    template {name dir builtindir tmpdir}
    input {notice deps path}
  } {
    set commands {}
    foreach member $members { dict set commands $member [list ::dg::query dotgen $group $member] }
    ensemble $both ::dotgen::$group $commands
  }
  ensemble $both ::dotgen {
    types {::dg::query dotgen types}
    components {::dg::query dotgen components}
    interfaces {::dg::query dotgen interfaces}
    parse ::dg::parse
  }
  foreach path $both {
    interp eval $path {namespace eval ::dotgen {namespace export genom input template}}
  }
  set commands {}
  foreach name {
    address argument cname declarator dereference invoke mangle mapping member pass return-value
    signature
  } {
    dict set commands $name [list ::dg::strict ::dg::query language $name]
  }
  ensemble $both ::language $commands
  ensemble $both ::object {
    types {::dg::query objects types}
    digest {::dg::query objects digest}
    unique {::dg::query objects unique}
  }
  ensemble main ::template {
    arg ::dg::template_arg
    deps ::dg::template_deps
    fatal ::dg::template_fatal
    message ::dg::template_message
    options ::dg::template_options
    parse ::dg::template_parse
    require ::dg::template_require
    usage ::dg::template_usage
  }
  ensemble main ::engine {
    chdir {::dg::strict ::dg::ask engine chdir}
    merge-tool {::dg::strict ::dg::ask engine merge-tool}
    mktemp {::dg::strict ::dg::ask engine mktemp}
    mode {::dg::strict ::dg::ask engine mode}
    pwd {::dg::strict ::dg::ask engine pwd}
  }
  interp alias main ::engine::open {} ::dg::engine_open
  interp alias main ::engine::close {} ::dg::engine_close
  foreach path $both {
    foreach name {comment fileext --- wrap} {
      interp alias $path $name {} ::dg::strict ::dg::query text $name
    }
    interp alias $path lang {} ::dg::lang
    interp eval $path [list proc indent {*}$indent]
  }
  interp alias main exit {} ::dg::exit_template
  interp alias main gsource {} ::dg::source_main
  interp alias $slave gsource {} ::dg::source_slave
  # Tcl gives safe interpreters an alias of this ensemble, where abbreviations end the process.
  interp alias $slave clock {} ::dg::clock
  # Channels: a source prints to the output of its template.
  interp share {} stderr $slave
  interp hide $slave puts
  interp alias $slave puts {} ::dg::puts_elsewhere
  # The commands of translated sources.
  interp eval $slave [list proc "\2=" {text end} {
    puts -nonewline [subst -nocommands -novariables $text]
  }]
  interp eval $slave [list proc "\2?" {text end} {
    puts -nonewline [uplevel 1 [list subst [subst -nocommands -novariables $text]]]
  }]
  # Tcl writes ::errorInfo while the commands that fail are still running: their places are kept
  # until the error ends the source or another one begins.
  interp eval $slave [list proc "\1note" {args} {
    upvar #0 ::errorInfo trace "\1trace" frames
    # The first command of a trace is "invoked" when it failed in another interpreter.
    if {[regexp -all {\n    (?:while executing|invoked from within)\n} $trace] > 1} return
    set frames {}
    for {set i [expr {[info frame] - 1}]} {$i > 0} {incr i -1} {
      set frame [info frame $i]
      if {[dict exists $frame file]} {
        lappend frames [dict get $frame file] [dict get $frame line] [dict get $frame cmd]
      }
    }
  }]
  interp eval $slave [list set "\1trace" {}]
  interp eval $slave [list trace add variable ::errorInfo write "\1note"]
}

proc ::dg::clock {args} { ::clock {*}$args }

proc ::dg::source_main {args} {
  if {[llength $args] != 1} { wrong_args "gsource ?fileName?" }
  interp eval main [list source -encoding utf-8 [lindex $args 0]]
}

proc ::dg::source_slave {args} {
  variable slave
  if {[llength $args] != 1} { wrong_args "gsource ?fileName?" }
  interp invokehidden $slave source -encoding utf-8 [lindex $args 0]
}

proc ::dg::leave {code} {
  catch {close stdout}
  ::dg::tcl_exit $code
}

# Commands of the main interpreter that reach outside it, when a template runs for a preview: what
# writes, starts programs or opens connections is refused but for files of its temporary directory.
proc ::dg::confine {} {
  variable tmpdir
  set ::env(TMPDIR) $tmpdir
  foreach name {exec socket load unload} {
    interp alias main $name {} ::dg::refuse $name
  }
  interp alias main clock {} ::dg::clock
  interp alias main open {} ::dg::confined_open
  interp alias main file {} ::dg::confined_file
  foreach name {cd encoding fconfigure glob pwd source} {
    interp expose main $name
  }
}

# Starts programs. Without a redirection, their input is empty.
proc ::dg::exec {args} {
  if {[llength [lsearch -all -glob $args <*]] == 0} {
    # An `&` stays the last word.
    set last [expr {[lindex $args end] eq "&" ? "end-1" : "end"}]
    set args [linsert $args $last < /dev/null]
  }
  interp invokehidden main exec {*}$args
}

proc ::dg::refuse {name args} {
  return -code error "\"$name\" is not allowed in a preview or with --confined: run the template from the\
      command line without it"
}

proc ::dg::inside {path} {
  variable tmpdir
  return [string match $tmpdir/* [file normalize $path]]
}

proc ::dg::confined_open {path args} {
  set access [lindex $args 0]
  if {[string index [string trim $path] 0] eq "|"} { refuse "open |" }
  if {$access ni {{} r RDONLY rb} && ![inside $path]} { refuse "open $path for writing" }
  interp invokehidden main open $path {*}$args
}

# Arguments behind the options of a command. Only what is an option counts as one: a path may begin with "-".
proc ::dg::without_options {options words} {
  while {[llength $words] && [string match -* [lindex $words 0]]} {
    set word [lindex $words 0]
    if {$word eq "-" || ![llength [lsearch -all -inline -glob $options $word*]]} break
    set words [lrange $words 1 end]
    if {$word eq "--"} break
  }
  return $words
}

# Of the arguments of a subcommand of "file", the paths that it changes.
proc ::dg::changed_paths {command words} {
  switch -- $command {
    delete - rename { return [without_options {-force --} $words] }
    copy { return [lrange [without_options {-force --} $words] end end] }
    link {
      set words [without_options {-symbolic -hard} $words]
      return [expr {[llength $words] > 1 ? $words : {}}]
    }
    attributes { return [expr {[llength $words] > 2 ? [list [lindex $words 0]] : {}}] }
    mtime - atime { return [expr {[llength $words] > 1 ? [list [lindex $words 0]] : {}}] }
    tempfile { return [lrange $words 1 end] }
  }
  return $words
}

proc ::dg::confined_file {command args} {
  if {$command eq "mkdir"} {
    # Directories are created with the generated files in them.
    set args [lmap path $args {if {![inside $path]} continue; set path}]
  }
  foreach change {delete rename copy mkdir link attributes mtime atime tempfile} {
    if {$command eq {} || ![string match [string map {* \\* ? \\? \[ \\[} $command]* $change]} continue
    foreach path [changed_paths $change $args] {
      # What may be meant by a shortened name does not matter where all of it is inside.
      if {![inside $path]} { refuse "file $command $path" }
    }
  }
  # A safe interpreter has only parts of this command; paths mean the same here.
  file $command {*}$args
}

proc ::dg::run {} {
  variable request
  variable reply
  variable slave
  variable status
  rename ::exit ::dg::tcl_exit
  if {[catch {
    set reply [open /dev/fd/0 r]
    set request [open /dev/fd/1 w]
  } message]} {
    puts stderr "dotgen: cannot talk to tclsh: $message"
    ::dg::tcl_exit 1
  }
  fconfigure $reply -translation binary -buffersize 65536
  fconfigure $request -translation binary -buffering full -buffersize 65536
  close stdin
  set in [chan create read ::dg::input_channel]
  close stdout
  set out [chan create write ::dg::output_channel]
  # Descriptors 0 and 1 are free now. A pipe to a program that a template starts would get these numbers,
  # and the program would close it.
  variable null [list [open /dev/null r] [open /dev/null w]]
  fconfigure $in -encoding utf-8 -buffering line
  fconfigure $out -encoding utf-8 -buffering none -buffersize 65536
  encoding system utf-8
  variable confined
  variable dir
  variable name
  variable tmpdir
  variable limit
  variable options {-h - --help {template fatal "no options available for this template"}}
  variable usage "Supported options:\n  -h.--help\t\tprint usage summary"
  variable parsed 0
  lassign [ask hello [info patchlevel]] confined name dir tmpdir limit argv
  if {$confined} {
    interp create -safe main
    interp share {} stdin main
    interp share {} stdout main
    interp share {} stderr main
    confine
  } else {
    interp create main
    # Programs cannot read the input of a template, which is a question to the engine.
    interp hide main exec
    interp alias main exec {} ::dg::exec
  }
  interp create -safe $slave
  populate
  interp eval main [list set ::argv $argv]
  interp eval main [list set ::argc [llength $argv]]
  interp eval main [list set ::argv0 $name]
  interp eval main {set ::tcl_interactive 0}
  set script [file join $dir template.tcl]
  set code [catch {interp eval main [list source -encoding utf-8 $script]} message info]
  set trace {}
  if {[dict exists $info -errorinfo]} { set trace [dict get $info -errorinfo] }
  if {!$code} { set status 0 }
  send done $code $status $message $trace
  leave 0
}

::dg::run

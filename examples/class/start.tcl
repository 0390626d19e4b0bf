# Drives the robot: tclsh start.tcl, while `dotgen run class.scn --clock real --listen 8080` goes on.
package require genomix

set g [genomix::connect]
$g load eye
$g load chase

proc setup {} {
    eye::set_swing {swing 2}
    chase::set_speed 0.3
}

proc met {request} {
    set ::met [expr {[catch {$request result} message] ? $message : "met"}]
}

setup
chase::meet {within 0.1} & met
vwait met
puts $met
puts "speed [dict get [chase::get_speed] speed] m/s"
if {[catch {chase::set_speed -- -1} message]} { puts $message }
after 100
puts "wheels [dict keys [dict get [chase::wheels] wheels]]"
chase::set_speed 0

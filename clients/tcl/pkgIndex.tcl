package ifneeded genomix 1.0 "[list source -encoding utf-8 [file join $dir values.tcl]]
[list source -encoding utf-8 [file join $dir genomix.tcl]]"

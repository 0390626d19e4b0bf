# The files that were read, and the one of the last type.
dotgen parse file {*}$argv
puts [dotgen input deps]
puts [lindex [[lindex [dotgen types] end] loc] 0]

# Starts programs, which have empty input.
puts [exec echo hello]
puts <[exec cat]>
puts [exec echo hello | tr a-z A-Z]
puts [exec cat << same]
set channel [open "|echo read" r]
puts [read -nonewline $channel]
close $channel

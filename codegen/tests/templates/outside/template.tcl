# Nothing of this may have an effect in a preview.
set dir [lindex $argv 0]
foreach script {
  {open $dir/written.txt w}
  {open "|true"}
  {exec true}
  {file delete $dir/kept.txt}
  {file copy $dir/kept.txt $dir/copy.txt}
  {file mkdir $dir/made}
  {socket localhost 1}
  {load x}
} {
  puts "[lindex $script 0] [lindex $script 1]: [catch $script]"
}
template parse raw "new\n" file $dir/kept.txt

# bash completion of drench: commands and options as its own help names them, words that are allowed, scene files.
# cmake --install puts it where bash-completion finds it; by hand: source tools/completion/drench.bash
_drench() {
  local program=${COMP_WORDS[0]} command=${COMP_WORDS[1]} before=${COMP_WORDS[COMP_CWORD-1]} word=${COMP_WORDS[COMP_CWORD]}
  local words=''
  COMPREPLY=()
  if ((COMP_CWORD == 1)); then
    words="--help --version $("$program" --help 2>/dev/null | sed -n '/^Subcommands:/,/^$/s/^  \([a-z]\{1,\}\) .*/\1/p')"
  elif [[ $before == --backend ]]; then
    words='kokkos reference'
  elif [[ $before == --to ]]; then
    words='usd bgeo ply'
  elif [[ $before == --liquid ]]; then
    words='auto particles surface'
  elif [[ $before == --camera ]]; then
    words='auto below front top'
  elif [[ $before == --direction ]]; then
    words='warp weft'
  elif [[ $command == fit && $before == --*test ]]; then
    words=$("$program" test 2>/dev/null | awk '{print $1}')
  elif [[ $word == -* ]]; then
    words=$("$program" "$command" --help 2>/dev/null | grep -oE '^ +(-[a-z],)?--[a-z-]+' | grep -oE -- '--[a-z-]+')
  else
    compopt -o default 2>/dev/null || true  # files and folders
    [[ $before == "$command" || $command == report || $command == fit ]] || return 0  # report takes two folders, fit several files
    case $command in
      import) mapfile -t COMPREPLY < <(for kind in usd usda usdc usdz fbx gltf glb abc blend xml json; do compgen -f -X "!*.$kind" -- "$word"; done) ;;
      fit) mapfile -t COMPREPLY < <(compgen -f -X '!*.csv' -- "$word") ;;
      new) mapfile -t COMPREPLY < <(for kind in obj ply stl usd usda usdc usdz fbx gltf glb abc blend; do compgen -f -X "!*.$kind" -- "$word"; done) ;;
      test) mapfile -t COMPREPLY < <(compgen -W "$("$program" test 2>/dev/null | awk '{print $1}')" -- "$word") ;;
      export | report | view) mapfile -t COMPREPLY < <(compgen -d -- "$word") ;;
      *) mapfile -t COMPREPLY < <(compgen -f -X '!*.yaml' -- "$word") ;;
    esac
    return
  fi
  mapfile -t COMPREPLY < <(compgen -W "$words" -- "$word")
}
complete -F _drench drench

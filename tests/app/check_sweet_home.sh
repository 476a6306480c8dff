#!/bin/bash
# check_sweet_home.sh - pictures of homes against Sweet Home 3D itself: the figures in tests/maps/sweethome are what the program says today,
# and homes of ../shared/data lie as it lays them. Skipped where Java, the Debian package sweethome3d or xvfb is not there.
. tests/app/checks.sh
source=tests/maps/sweethome
jars=/usr/share/sweethome3d/sweethome3d.jar
command -v javac >/dev/null && command -v xvfb-run >/dev/null && [ -e $jars ] || skip 'javac, xvfb-run or Sweet Home 3D is not here'
for jar in /usr/share/java/{batik-all,janino,commons-compiler,sunflow,j3dcore,j3dutils,vecmath}.jar /usr/share/java/freehep-*.jar; do
    jars=$jars:$jar
done
javac -nowarn -d "$work" -cp "$jars" $source/SweetHomeCorners.java >"$work/out" 2>&1 || die "javac: $(head -2 "$work/out")"
# corners HOME: into $work/corners.
corners() {
    xvfb-run -a java -Xmx2g -Djava.library.path=/usr/lib/jni --add-exports java.desktop/sun.awt=ALL-UNNAMED -cp "$work:$jars" \
        SweetHomeCorners "$1" >"$work/corners" 2>"$work/err" || die "$1: $(head -2 "$work/err")"
}
for figures in $source/*.corners; do
    home=maps/buildings/$(basename "$figures" .corners).sh3d
    [ -e "$home" ] || continue  # a stranger's, below
    corners "$home"
    same "$work/corners" "$figures" "$figures is not what Sweet Home 3D says of $home"
done
for home in ../shared/data/sh3d/textured-room.sh3d ../shared/data/sh3d-textured/*.sh3d; do
    [ -e "$home" ] || continue
    corners "$home"
    HOME_FILE=$home HOME_CORNERS=$work/corners CORNERS_LIST=1 "$build/tests/all" --filter sh3d_textures/lie_so_in_a_given_home \
        >"$work/out" 2>&1 || fail "$home: $(head -3 "$work/out")"
    grep -q 'Tested: 1' "$work/out" || fail "$home: $(head -3 "$work/out")"
done
exit $bad

# Enfilade. On a bare Debian 12 machine: `make walk` (sets up, builds, opens a window), `make test`.
#   make [config=release|debug|asan|tsan] [CC=gcc|clang] [arch=x86-64] [mpi=1]   program and sample buildings
#   make test | soak | asan | tsan | fuzz | mutants | coverage | portable | bench | figures | pictures |
#        charts | lint | docs | install PREFIX= DESTDIR= | clean
config ?= release
PREFIX ?= /usr/local
fuzz_seconds ?= 60
mutants ?=
bench ?= walk
folder ?= maps
suites ?= */*
# What to measure (default: the sample plans), and with bench=visibility a compiler to compare with.
scale := $(foreach n,10 100 1000 10000,build/maps/campus-$(n).plan)
rooms := $(foreach n,10 30 100 300 1000,build/maps/rooms-$(n).plan build/maps/enfilade-$(n).plan)
lit := build/maps/office-plain.plan build/maps/house.plan
files ?= $(if $(filter rooms,$(bench)),$(rooms),$(if $(filter scale,$(bench)),$(scale),$(if $(filter light meshes,$(bench)),$(lit),\
         $(if $(filter narrow,$(bench)),$(sort $(wildcard tests/narrow/*.plan)),\
         $(filter %.plan,$(if $(filter radiosity,$(bench)),$(filter build/maps/office%,$(maps)),$(maps)))))))
peer ?=
ifeq ($(origin CC),default)
CC := gcc
endif
ifeq ($(origin CXX),default)
CXX := g++
endif
# The processor: of x86 one with AVX2 and FMA, 2013 or later; arch=x86-64 is any. Of others the compiler's own least one.
arch ?= $(if $(filter x86_64%,$(shell $(CC) -dumpmachine)),x86-64-v3,armv8-a)
# All cores, unless the caller said how many. Known in recipes only: make hides it from itself while it reads.
submake = +@$(MAKE) --no-print-directory $(if $(findstring jobserver,$(MAKEFLAGS)),,-j$(shell nproc))

# mpi=1: bakes in several processes, by Open MPI. The program is in a folder of its own, build/release-mpi.
mpi ?=
dir := build/$(config)$(if $(mpi),-mpi)
layers := engine/core engine/team engine/gl maps/building maps/photometry maps/curved maps/enclose maps/polygons maps/plan maps/sweethome \
          maps/doom maps/quake maps/ifc maps/ifc_building maps visibility visibility/cells visibility/soup visibility/trees visibility/query \
          visibility/pairs visibility/prepare visibility/bezier visibility/rays visibility/hidden radiosity/daylight radiosity/mesh \
          radiosity/factors radiosity/methods radiosity/shoot radiosity/truth radiosity/show radiosity/follow radiosity/planner engine/sim \
          engine/tour engine/library engine/scene engine/shade engine/lit engine/draw engine/overlay engine/display engine/walk engine/stills engine/app \
          engine/bench engine/bench/light
# Clang tells of loops that it does not vectorise, under a sanitizer or with counters: that is no fault.
strict := -Wall -Wextra -Wpedantic -Wshadow -Werror -Wno-pass-failed
# Where the processor has no vectors as wide as ours, the compiler warns that others may pass them otherwise: all files here agree.
# One set of machine flags for all files: the alignment of cglm's types depends on it. No contraction of
# multiply and add: the same input gives the same bytes whatever the compiler. The objects serve the shared library
# too; protected, its functions call each other as directly as those of a program.
base := -Wno-psabi -std=c17 -D_GNU_SOURCE -ffp-contract=off -march=$(arch) -fopenmp -fPIC -fvisibility=protected -g -MMD -MP \
        -I. -Ibuild/glad/include
sanitize := -O1 -fno-omit-frame-pointer -fno-sanitize-recover=undefined
flags_release := -O2
flags_debug := -O0
# For another `arch` in a folder of its own (make portable).
flags_plain := -O2
flags_asan := $(sanitize) -fsanitize=address,undefined
# By clang: of gcc's OpenMP the thread sanitizer does not know who waits for whom.
flags_tsan := -O1 -fno-omit-frame-pointer -fsanitize=thread
flags_fuzz := $(sanitize) -fsanitize=address,undefined,fuzzer-no-link
# Counts what runs, edge by edge: tests/maps/hostile_cost.c alone.
flags_counted := -O1 -g0 -fsanitize-coverage=trace-pc
# Without sanitizers a reader is tried ten times as often. What is found so goes through config=fuzz, too.
flags_swift := -O2 -fsanitize-coverage=inline-8bit-counters,pc-table
flags_coverage := -O1 --coverage
flags_mpi := $(if $(mpi),-DENFILADE_MPI $(patsubst -I%,-isystem %,$(shell mpicc --showme:compile)))
CFLAGS_ALL = $(base) $(flags_$(config)) $(flags_mpi) $(CFLAGS)
# The font of the overlay becomes part of the program.
fonts := /usr/share/fonts/truetype/dejavu
libs := $(if $(mpi),$(shell mpicc --showme:link)) -lgeos_c -lminizip -lexpat -lpng -lwebp -lassimp -ljansson -lglfw -lembree3 -lm

sources := $(foreach l,$(layers),$(wildcard $(l)/*.c))
# Of one configuration alone; the file says why.
only_asan := tests/support/keep_libraries.c
objects := $(patsubst %.c,$(dir)/%.o,$(sources) $(only_$(config))) $(dir)/glad/gl.o
# Without the programs' own: the rest is what tests link.
mains := $(dir)/engine/app/main.o $(dir)/engine/bench/main.o
library := $(filter-out $(mains),$(objects))
maps := build/maps/two-rooms.plan build/maps/house.plan build/maps/house.sh3d build/maps/office.plan \
        build/maps/office-plain.plan build/maps/flat.Home.xml build/maps/hillside.sh3d build/maps/villa.sh3d

to_build := gcc libc6-dev python3-glad libgeos-dev libminizip-dev libexpat1-dev libpng-dev libwebp-dev libassimp-dev libjansson-dev \
            libxxhash-dev libosmesa6-dev libembree-dev libcglm-dev libstb-dev libglfw3-dev \
            fonts-dejavu-core
to_build += $(if $(mpi),libopenmpi-dev openmpi-bin)
to_walk := libgl1 libglx-mesa0 libgl1-mesa-dri ffmpeg
to_test := $(to_walk) libzip-dev time libcriterion-dev libglm-dev g++ zip xvfb xauth xdotool python3 freedoom
to_portable := gcc-aarch64-linux-gnu libc6-dev-arm64-cross qemu-user
to_lint := clang-format cppcheck gcc git python3
to_pictures := gnuplot-nox imagemagick librsvg2-bin fonts-dejavu-core ffmpeg
to_docs := doxygen
to_fuzz := clang libclang-rt-14-dev libomp-dev
# $(call missing,PACKAGES): shell that sets $$missing; empty where dpkg does not say.
missing = missing=$$(command -v dpkg-query >/dev/null && for p in $(1); do dpkg-query -W -f '$${Status}' $$p \
          2>/dev/null | grep -q ' installed' || printf ' %s' $$p; done); true
# $(call install,PACKAGES): installs what is missing, saying what.
install = @$(call missing,$(1)); if [ -n "$$missing" ]; then echo "installing with apt:$$missing"; \
          sudo=$$([ $$(id -u) = 0 ] || echo sudo); $$sudo apt-get -q update && \
          $$sudo env DEBIAN_FRONTEND=noninteractive apt-get -q install -y --no-install-recommends $$missing; fi

.PHONY: all program maps house check-packages walk test soak soaked asan tsan fuzz mutants coverage portable bench figures pictures charts lint libraries install \
        docs clean FORCE
all:
	$(submake) program maps
program: $(dir)/enfilade $(dir)/enfilade-bench
maps: $(maps)

check-packages:
	@$(call missing,$(to_build)); [ -z "$$missing" ] || { echo "missing packages:$$missing (make walk installs \
	them, or apt-get install them)" >&2; exit 1; }

$(dir)/enfilade: $(dir)/engine/app/main.o $(filter-out $(dir)/engine/bench/%,$(library))
	@echo "link $@" && $(CC) $(CFLAGS_ALL) -o $@ $^ $(libs)
$(dir)/enfilade-bench: $(dir)/engine/bench/main.o $(library)
	@echo "link $@" && $(CC) $(CFLAGS_ALL) -o $@ $^ $(libs)
$(dir)/%.o: %.c build/glad/include/glad/gl.h $(dir)/flags | check-packages
	@mkdir -p $(@D) && echo "$(CC) $<"
	@$(CC) $(CFLAGS_ALL) $(strict) -c -o $@ $<
# Private: the flags file, on which everything depends, must not see it.
$(dir)/engine/overlay/font.o: private CFLAGS_ALL += -Wa,-I$(fonts)
$(dir)/%.o: %.cpp $(dir)/flags | check-packages
	@mkdir -p $(@D) && echo "$(CXX) $<"
	@$(CXX) $(patsubst -std=c17,-std=c++17,$(CFLAGS_ALL)) $(strict) -c -o $@ $<
$(dir)/glad/gl.o: build/glad/include/glad/gl.h $(dir)/flags
	@mkdir -p $(@D)
	@$(CC) $(CFLAGS_ALL) -w -c -o $@ build/glad/src/gl.c
# Rebuilds everything when the compiler or its flags change.
$(dir)/flags: FORCE
	@mkdir -p $(@D)
	@echo '$(CC) $(CFLAGS_ALL)' | cmp -s - $@ || echo '$(CC) $(CFLAGS_ALL)' > $@
build/glad/include/glad/gl.h: | check-packages
	glad --quiet --reproducible --api gl:core=3.3 --out-path build/glad c --loader

build/generate: maps/buildings/generate.c maps/buildings/campus.c maps/buildings/campus.h
	@mkdir -p $(@D)
	$(CC) -std=c17 -O2 $(strict) -ffp-contract=off -I. -o $@ $(filter %.c,$^) -lm
define generate
@mkdir -p $(@D)
build/generate $(basename $(@F)) 1 > $@.new && mv $@.new $@
endef
build/maps/office%plan: build/generate
	$(generate)
build/maps/rooms-%.plan: build/generate
	$(generate)
build/maps/enfilade-%.plan build/maps/campus-%.plan build/maps/corridor-%.plan build/maps/atrium-%.plan build/maps/glass-%.plan: \
        build/generate
	$(generate)
build/maps/storeys-%.ifc: maps/buildings/storeys_ifc.py
	@mkdir -p $(@D)
	$< $* $@.new && mv $@.new $@
build/maps/%: maps/buildings/%
	@mkdir -p $(@D)
	cp $< $@

# Only needed after a change of house.plan or of the scripts: the results are committed.
house:
	maps/buildings/house_sh3d.py maps/buildings/house.plan maps/buildings/house.sh3d
	maps/buildings/homes.py maps/buildings
	maps/buildings/textures_sh3d.py maps/buildings/textures.sh3d

walk:
	$(call install,$(to_build) $(to_walk))
	$(submake) config=release program maps
	@if [ -n "$$DISPLAY$$WAYLAND_DISPLAY" ]; then \
	    echo "H shows the keys"; build/release/enfilade walk build/maps/house.plan --pictures build/walk; \
	else \
	    echo "no display: a tour is drawn off-screen"; \
	    build/release/enfilade walk build/maps/house.plan --offscreen build/walk --tour auto \
	        --video build/walk/house.mp4 --stats build/walk/house.csv; \
	fi
include tests/tests.mk
include engine/library/library.mk
clean:
	rm -rf build

-include $(objects:.o=.d) $(tests:.o=.d) $(wildcard $(dir)/tests/*/*.d)
.DELETE_ON_ERROR:
.SECONDARY:

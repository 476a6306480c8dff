# Enfilade. On a bare Debian 12 machine: `make walk` (sets up, builds, opens a window), `make test`.
#   make [config=release|debug|asan|tsan] [CC=gcc|clang]   program and sample buildings
#   make test | soak | asan | tsan | fuzz | mutants | coverage | bench | pictures | charts | lint | docs |
#        install PREFIX= DESTDIR= | clean
config ?= release
PREFIX ?= /usr/local
fuzz_seconds ?= 60
mutants ?=
bench ?= walk
folder ?= maps
suites ?= */*
# What to measure (default: the sample plans), and with bench=visibility a compiler to compare with.
rooms := $(foreach n,10 30 100 300 1000,build/maps/rooms-$(n).plan build/maps/enfilade-$(n).plan)
lit := build/maps/office-plain.plan build/maps/house.plan
files ?= $(if $(filter rooms,$(bench)),$(rooms),$(if $(filter light meshes,$(bench)),$(lit),\
         $(filter %.plan,$(if $(filter radiosity,$(bench)),$(filter build/maps/office%,$(maps)),$(maps)))))
peer ?=
ifeq ($(origin CC),default)
CC := gcc
endif
ifeq ($(origin CXX),default)
CXX := g++
endif
# All cores, unless the caller said how many. Known in recipes only: make hides it from itself while it reads.
submake = +@$(MAKE) --no-print-directory $(if $(findstring jobserver,$(MAKEFLAGS)),,-j$(shell nproc))

dir := build/$(config)
layers := engine/core engine/gl maps/building maps/curved maps/enclose maps/plan maps/polygons maps/sweethome \
          maps/doom maps visibility visibility/cells visibility/soup visibility/trees visibility/query \
          visibility/pairs visibility/prepare visibility/bezier visibility/rays visibility/hidden radiosity/mesh \
          radiosity/factors radiosity/methods radiosity/shoot radiosity/truth radiosity/show engine/sim \
          engine/library engine/scene engine/draw engine/overlay engine/walk engine/stills engine/app engine/bench
strict := -Wall -Wextra -Wpedantic -Wshadow -Werror
# One set of machine flags for all files: the alignment of cglm's types depends on it. No contraction of
# multiply and add: the same input gives the same bytes whatever the compiler. The objects serve the shared library
# too; protected, its functions call each other as directly as those of a program.
base := -std=c17 -D_GNU_SOURCE -ffp-contract=off -march=x86-64-v3 -fopenmp -fPIC -fvisibility=protected -g -MMD -MP \
        -I. -Ibuild/glad/include
sanitize := -O1 -fno-omit-frame-pointer -fno-sanitize-recover=undefined
flags_release := -O2
flags_debug := -O0
flags_asan := $(sanitize) -fsanitize=address,undefined
# By clang: of gcc's OpenMP the thread sanitizer does not know who waits for whom.
flags_tsan := -O1 -fno-omit-frame-pointer -fsanitize=thread
flags_fuzz := $(sanitize) -fsanitize=address,undefined,fuzzer-no-link
# Counts what runs, edge by edge: tests/maps/hostile_cost.c alone.
flags_counted := -O1 -g0 -fsanitize-coverage=trace-pc
# Without sanitizers a reader is tried ten times as often. What is found so goes through config=fuzz, too.
flags_swift := -O2 -fsanitize-coverage=inline-8bit-counters,pc-table
flags_coverage := -O1 --coverage
CFLAGS_ALL = $(base) $(flags_$(config)) $(CFLAGS)
# The font of the overlay becomes part of the program.
fonts := /usr/share/fonts/truetype/dejavu
libs := -lgeos_c -lminizip -lexpat -lpng -ljansson -lglfw -lOSMesa -lembree3 -lm

sources := $(foreach l,$(layers),$(wildcard $(l)/*.c))
# Of one configuration alone; the file says why.
only_asan := tests/support/keep_libraries.c
objects := $(patsubst %.c,$(dir)/%.o,$(sources) $(only_$(config))) $(dir)/glad/gl.o
# Without the programs' own: the rest is what tests link.
mains := $(dir)/engine/app/main.o $(dir)/engine/bench/main.o
library := $(filter-out $(mains),$(objects))
# The installed libraries: all below the scenes, apart by the libraries that they need in their turn.
base_layers := engine/core $(filter maps%,$(layers)) visibility $(patsubst %,visibility/%,cells soup trees query pairs prepare) engine/sim
light_layers := engine/gl $(patsubst %,visibility/%,bezier rays hidden) $(filter radiosity%,$(layers))
objects_in = $(patsubst %.c,$(dir)/%.o,$(foreach l,$(1),$(wildcard $(l)/*.c)))
base_libs := -lgeos_c -lminizip -lexpat -ljansson -lm
light_libs := -lOSMesa -lembree3 -lm
version := $(shell sed -n 's/.*APP_VERSION "\(.*\)"/\1/p' engine/app/app.h)
major := $(firstword $(subst ., ,$(version)))
soname := libenfilade.so.$(major)
programs_of_tests := tests/maps/make_hostile.c tests/maps/hostile_cost.c tests/core/fail_malloc.c
tests := $(patsubst %.c,$(dir)/%.o,$(filter-out tests/fuzz/% tests/samples/% $(programs_of_tests) $(only_asan),$(wildcard tests/*/*.c))) \
         $(patsubst %.cpp,$(dir)/%.o,$(wildcard tests/*/*.cpp))
fuzzers := $(patsubst tests/fuzz/%.c,%,$(wildcard tests/fuzz/fuzz_*.c))
fuzz_help := $(patsubst %,$(dir)/tests/%.o,fuzz/target fuzz/store_target support/wad_builder support/home_fixture \
             support/fixture)
maps := build/maps/two-rooms.plan build/maps/house.plan build/maps/house.sh3d build/maps/office.plan \
        build/maps/office-plain.plan build/maps/flat.Home.xml build/maps/hillside.sh3d build/maps/villa.sh3d

to_build := gcc libc6-dev python3-glad libgeos-dev libminizip-dev libexpat1-dev libpng-dev libjansson-dev \
            libxxhash-dev libosmesa6-dev libembree-dev libcglm-dev libstb-dev libglfw3-dev \
            fonts-dejavu-core
to_walk := libgl1 libglx-mesa0 libgl1-mesa-dri ffmpeg
to_test := $(to_walk) libzip-dev time libcriterion-dev libglm-dev g++ zip xvfb xauth xdotool python3 freedoom
to_lint := clang-format cppcheck
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

.PHONY: all program maps house check-packages walk test soak soaked asan tsan fuzz mutants coverage bench pictures charts lint libraries install \
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
$(dir)/tests/all: $(library) $(tests)
	@echo "link $@" && $(CC) $(CFLAGS_ALL) -o $@ $^ -lcriterion -lstdc++ -lzip $(libs)
# From an archive, so that a target holds what it needs and no more: after every try libFuzzer looks at all counters.
# Files come from the target where it serves them (tests/fuzz/target.h).
$(dir)/fuzzed.a: $(library) $(fuzz_help)
	@rm -f $@ && ar rcs $@ $^
$(dir)/tests/fuzz_%: $(dir)/tests/fuzz/fuzz_%.o $(dir)/tests/fuzz/mutator.o $(dir)/fuzzed.a
	@echo "link $@" && $(CC) $(CFLAGS_ALL) -fsanitize=fuzzer -Wl,--wrap=file_read -o $@ $^ -lzip $(libs)
$(dir)/tests/try_fuzz_%: $(dir)/tests/fuzz/fuzz_%.o $(dir)/tests/fuzz/try_fuzz.o $(dir)/tests/fuzz/mutator.o $(dir)/fuzzed.a
	@echo "link $@" && $(CC) $(CFLAGS_ALL) -Wl,--wrap=file_read -o $@ $^ -lzip $(libs)
$(dir)/tests/make_hostile: $(dir)/tests/support/hostile.o $(dir)/tests/maps/make_hostile.o
	@echo "link $@" && $(CC) $(CFLAGS_ALL) -o $@ $^ -lm
# What opens a building, without what draws or lights it.
counted := $(patsubst %.c,$(dir)/%.o,$(foreach l,$(filter-out visibility/hidden,$(filter engine/core maps% visibility%,$(layers))),$(wildcard $(l)/*.c)))
$(dir)/tests/hostile_cost: $(counted) $(dir)/tests/support/hostile.o $(dir)/tests/maps/hostile_cost.o
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

build/generate: maps/buildings/generate.c
	@mkdir -p $(@D)
	$(CC) -std=c17 -O2 $(strict) -ffp-contract=off -I. -o $@ $< -lm
define generate
@mkdir -p $(@D)
build/generate $(basename $(@F)) 1 > $@.new && mv $@.new $@
endef
build/maps/office%plan: build/generate
	$(generate)
build/maps/rooms-%.plan: build/generate
	$(generate)
build/maps/enfilade-%.plan: build/generate
	$(generate)
build/maps/%: maps/buildings/%
	@mkdir -p $(@D)
	cp $< $@

# Only needed after a change of house.plan or of the scripts: the results are committed.
house:
	maps/buildings/house_sh3d.py maps/buildings/house.plan maps/buildings/house.sh3d
	maps/buildings/homes.py maps/buildings

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
test soak:
	$(call install,$(to_build) $(to_test))
	$(submake) program maps $(dir)/tests/all $(dir)/tests/make_hostile $(fuzzers:fuzz_%=$(dir)/tests/try_fuzz_%)
	$(submake) config=counted build/counted/tests/hostile_cost
	@ENFILADE_SOAK=$(if $(filter soak,$@),1) ENFILADE_SOAK_MINUTES=2 tests/run.sh $(dir)
	$(if $(filter soak,$@),$(submake) config=asan soaked)
# Twenty minutes of everything that a walk can do, under the sanitizers.
soaked: all $(dir)/tests/all
	@ENFILADE_BUILD=$(dir) ENFILADE_SOAK=1 LSAN_OPTIONS=suppressions=tests/lsan.supp:print_suppressions=0 \
	    ASAN_OPTIONS=quarantine_size_mb=32 $(dir)/tests/all --filter 'soak/*'
asan:
	$(submake) config=asan test
tsan:
	$(call install,$(to_build) $(to_test) $(to_fuzz))
	$(submake) config=tsan CC=clang all build/maps/rooms-300.plan
	@ENFILADE_BUILD=build/tsan bash tests/tsan.sh
fuzz:
	$(call install,$(to_build) $(to_fuzz))
	$(submake) config=fuzz CC=clang $(fuzzers:%=build/fuzz/tests/%)
	$(submake) config=swift CC=clang $(fuzzers:%=build/swift/tests/%)
	$(submake) config=coverage $(fuzzers:fuzz_%=build/coverage/tests/try_fuzz_%)
	@bash tests/fuzz/fuzz.sh $(fuzz_seconds); status=$$?; bash tests/coverage.sh build/coverage maps '' build/fuzz/corpus; exit $$status
# Faults of one line that the tests should notice: `make mutants mutants="--only query --again"`; tests/mutants.py tells more.
mutants: maps program $(dir)/tests/all
	@python3 tests/mutants.py --compile '$(CC) $(CFLAGS_ALL)' --link '$(CC) $(CFLAGS_ALL) $(library) $(tests) -lcriterion -lstdc++ -lzip $(libs)' \
	    $(mutants)
# The share of lines that tests and seeds run, by file of a folder; of suites that match a pattern, e.g. suites='wad*/*'.
coverage:
	$(call install,$(to_build) $(to_test))
	$(submake) config=coverage program maps build/coverage/tests/all $(fuzzers:fuzz_%=build/coverage/tests/try_fuzz_%)
	@bash tests/coverage.sh build/coverage $(folder) '$(suites)'
bench: all $(filter build/maps/%,$(files))
	@mkdir -p build/bench
	$(dir)/enfilade bench $(bench) $(files) $(if $(peer),--peer $(peer)) | tee build/bench/$(bench).csv
# The pictures of the README; the charts show the benchmarks as `make bench` left them.
pictures:
	$(call install,$(to_build) $(to_pictures))
	$(submake) all
	@mkdir -p build/pictures tests/pictures
	for view in living kitchen courtyard study; do $(dir)/enfilade walk build/maps/house.plan --size 1200x675 \
	    --offscreen build/pictures/$$view --tour $$view || exit 1; done
	montage $(patsubst %,build/pictures/%/frame-00000.png,living kitchen courtyard study) -tile 2x2 -geometry 600x338+3+3 \
	    -depth 8 -colors 200 tests/pictures/house.png
	$(dir)/enfilade plan build/maps/two-rooms.plan --from 1,1,1.5 --width 800 -o build/pictures/plan.svg
	rsvg-convert build/pictures/plan.svg -o tests/pictures/plan.png
	# The film replays a recorded path, which holds for house.plan as it is: after a change record another in the window.
	rm -rf build/pictures/film
	$(dir)/enfilade walk build/maps/house.plan --replay tests/pictures/walk.path --offscreen build/pictures/film \
	    --size 480x270 --every 6
	ffmpeg -loglevel error -y -framerate 10 -i build/pictures/film/frame-%05d.png -vf "scale=360:-1:flags=lanczos,\
	split[a][b];[a]palettegen=max_colors=64:stats_mode=diff[p];[b][p]paletteuse=dither=none:diff_mode=rectangle" \
	    tests/pictures/walk.gif
	$(dir)/enfilade bake build/maps/house.plan -o build/pictures/house.rad
	for view in living bedroom kitchen; do $(dir)/enfilade walk build/maps/house.plan --light build/pictures/house.rad \
	    --size 800x450 --offscreen build/pictures/baked-$$view --tour $$view || exit 1; done
	montage $(patsubst %,build/pictures/baked-%/frame-00000.png,bedroom kitchen) -tile 2x1 -geometry 600x338+0+0 \
	    -depth 8 -colors 200 tests/pictures/baked.png
	$(dir)/enfilade walk build/maps/house.plan --light build/pictures/house.rad --false-colour illuminance \
	    --size 800x450 --offscreen build/pictures/lux-living --tour living
	montage build/pictures/baked-living/frame-00000.png build/pictures/lux-living/frame-00000.png -tile 2x1 \
	    -geometry 600x338+0+0 -depth 8 -colors 200 tests/pictures/lit.png
	$(dir)/enfilade render build/maps/house.plan --light build/pictures/house.rad --view still --samples 64 \
	    -o build/pictures/still.png
	convert build/pictures/still.png -strip -define png:compression-level=9 tests/pictures/still.png
	# Errors of what is shown, and the same view: where one begins. The truth is coarse: minutes of path tracing even so.
	$(dir)/enfilade bench light build/maps/office-plain.plan --methods default --points 1 --error 0.5 --size 96x54 \
	    --pictures build/pictures >build/pictures/light-error.csv
	$(dir)/enfilade bake build/maps/office-plain.plan -o build/pictures/office-plain.rad
	$(dir)/enfilade walk build/maps/office-plain.plan --light build/pictures/office-plain.rad --size 480x270 \
	    --offscreen build/pictures/office-plain --every 100000
	rsvg-convert build/pictures/light-error-scale.svg -o build/pictures/light-error-scale.png
	montage build/pictures/office-plain/frame-00000.png '(' build/pictures/default-error.png -filter point -resize \
	    480x270 ')' -tile 2x1 -geometry 480x270+3+3 -depth 8 miff:- | convert - build/pictures/light-error-scale.png \
	    -gravity center -append -colors 128 tests/pictures/light-error.png
	$(dir)/enfilade bench radiosity --pictures build/pictures >build/pictures/radiosity.csv
	montage build/pictures/doi-itoh-2-hemicube.png build/pictures/doi-itoh-2-hemisphere.png -tile 2x1 -geometry +3+3 \
	    -colors 128 tests/pictures/hemicube-hemisphere.png
	montage tests/references/hall-plan.png tests/references/hall-wireframe.png tests/references/lookout-frozen.png \
	    -tile 3x1 -geometry +3+3 tests/pictures/debug.png
	$(MAKE) --no-print-directory charts
charts:
	gnuplot -e "csv='build/bench/walk.csv'; out='tests/pictures/culling.png'" tests/plots/walk.gp
	@mkdir -p build/pictures
	for chart in $(filter-out walk,$(patsubst tests/plots/%.gp,%,$(wildcard tests/plots/*.gp))); do \
	    [ ! -e build/bench/$$chart.csv ] || { gnuplot -e "csv='build/bench/$$chart.csv'; out='build/pictures/$$chart'" \
	    tests/plots/$$chart.gp && cp build/pictures/$$chart.png tests/pictures; } || exit 1; done
lint:
	$(call install,$(to_lint))
	@echo clang-format && clang-format --dry-run -Werror $(wildcard $(layers:%=%/*.[ch]) maps/buildings/*.c tests/*/*.[ch] tests/*/*.cpp)
	cppcheck --quiet --error-exitcode=1 --std=c11 --enable=warning,performance,portability --inline-suppr \
	    --suppress=missingIncludeSystem -I. -D__GNUC__ -j$(shell nproc) $(layers) maps/buildings
	$(submake) program
	python3 tests/structure.py $(dir)
# Each library is one object, in which every name has the prefix, and gives away the names of its headers alone.
$(dir)/libenfilade.rename: $(call objects_in,$(base_layers)) $(call objects_in,$(light_layers)) $(dir)/glad/gl.o $(wildcard engine/library/*.py) \
                           $(wildcard $(layers:%=%/*.h) engine/library/*.h)
	@rm -rf $(dir)/include && python3 engine/library/headers.py $(dir)/include/enfilade $(dir)/libenfilade.headers
	@$(CC) -r -nostdlib -o $(dir)/libenfilade.o $(call objects_in,$(base_layers))
	@$(CC) -r -nostdlib -o $(dir)/libenfilade-light.o $(call objects_in,$(light_layers)) $(dir)/glad/gl.o
	@python3 engine/library/exports.py $(dir)/libenfilade.headers $(dir)/libenfilade.o $(dir)/libenfilade-light.o $(dir)/libenfilade
	@for l in libenfilade libenfilade-light; do objcopy --redefine-syms=$@ $(dir)/$$l.o || exit 1; done
	@for l in base light; do (echo '{ global:'; sed 's/$$/;/' $(dir)/libenfilade.$$l; echo 'local: *; };') >$(dir)/libenfilade.$$l.map; done
$(dir)/libenfilade.so: $(dir)/libenfilade.rename
	@echo "link $@" && $(CC) $(CFLAGS_ALL) -shared -Wl,-soname,$(soname) -Wl,-z,defs,--as-needed \
	    -Wl,--version-script=$(dir)/libenfilade.base.map -o $@ $(dir)/libenfilade.o $(base_libs)
$(dir)/libenfilade-light.so: $(dir)/libenfilade.so
	@echo "link $@" && $(CC) $(CFLAGS_ALL) -shared -Wl,-soname,$(soname:libenfilade%=libenfilade-light%) -Wl,-z,defs,--as-needed \
	    -Wl,--version-script=$(dir)/libenfilade.light.map -o $@ $(dir)/libenfilade-light.o -L$(dir) -lenfilade $(light_libs)
$(dir)/lib%.a: $(dir)/libenfilade-light.so
	@echo "link $@" && rm -f $@ && ar rcs $@ $(dir)/lib$*.o
$(dir)/enfilade.1: $(dir)/enfilade engine/library/man.sh
	@sh engine/library/man.sh $< >$@
libraries: $(dir)/libenfilade.a $(dir)/libenfilade-light.a
install: all
	$(submake) libraries $(dir)/enfilade.1
	install -D -m 755 -t $(DESTDIR)$(PREFIX)/bin $(dir)/enfilade $(dir)/enfilade-bench
	install -D -m 644 $(dir)/enfilade.1 $(DESTDIR)$(PREFIX)/share/man/man1/enfilade.1
	install -D -m 644 engine/library/enfilade.bash $(DESTDIR)$(PREFIX)/share/bash-completion/completions/enfilade
	install -D -m 644 engine/library/_enfilade $(DESTDIR)$(PREFIX)/share/zsh/site-functions/_enfilade
	install -d $(DESTDIR)$(PREFIX)/share/enfilade $(DESTDIR)$(PREFIX)/include
	install -m 644 $(maps) maps/README.md LICENSE engine/NOTICES $(DESTDIR)$(PREFIX)/share/enfilade
	for l in libenfilade libenfilade-light; do \
	    install -D -m 644 $(dir)/$$l.a $(DESTDIR)$(PREFIX)/lib/$$l.a && \
	    install -D -m 755 $(dir)/$$l.so $(DESTDIR)$(PREFIX)/lib/$$l.so.$(version) && \
	    ln -sf $$l.so.$(version) $(DESTDIR)$(PREFIX)/lib/$$l.so.$(major) && ln -sf $$l.so.$(major) $(DESTDIR)$(PREFIX)/lib/$$l.so || exit 1; \
	done
	cp -r $(dir)/include/enfilade $(DESTDIR)$(PREFIX)/include
	@mkdir -p $(DESTDIR)$(PREFIX)/lib/pkgconfig
	for l in enfilade enfilade-light; do \
	    sed 's|@PREFIX@|$(PREFIX)|; s|@VERSION@|$(version)|; s|@BASE_LIBS@|$(base_libs) -fopenmp|; s|@LIGHT_LIBS@|$(light_libs) -fopenmp|' \
	        engine/library/$$l.pc.in >$(DESTDIR)$(PREFIX)/lib/pkgconfig/$$l.pc || exit 1; \
	done
docs:
	$(call install,$(to_docs))
	@rm -rf build/docs && mkdir -p build/docs
	@python3 engine/library/headers.py build/docs/include/enfilade build/docs/names
	doxygen engine/library/Doxyfile
	@# Members of structs may speak for themselves; types and functions may not.
	@(cat engine/library/Doxyfile; echo 'EXTRACT_ALL = NO'; echo 'GENERATE_HTML = NO'; echo 'WARN_AS_ERROR = NO') | \
	    doxygen - 2>&1 | grep -E '(Compound|\((function|typedef)\)).*is not documented' && exit 1 || true
	@echo "build/docs/html/index.html"
clean:
	rm -rf build

-include $(objects:.o=.d) $(tests:.o=.d) $(wildcard $(dir)/tests/*/*.d)
.DELETE_ON_ERROR:
.SECONDARY:

# tests.mk - tests, fuzzing, mutants, benchmarks, pictures, lint; part of the Makefile.

programs_of_tests := tests/maps/make_hostile.c tests/maps/hostile_cost.c tests/core/fail_malloc.c
tests := $(patsubst %.c,$(dir)/%.o,$(filter-out tests/fuzz/% tests/samples/% tests/portable/% $(programs_of_tests) $(only_asan),$(wildcard tests/*/*.c tests/*/*/*.c))) \
         $(patsubst %.cpp,$(dir)/%.o,$(wildcard tests/*/*.cpp))
fuzzers := $(patsubst tests/fuzz/%.c,%,$(wildcard tests/fuzz/fuzz_*.c))
fuzz_help := $(patsubst %,$(dir)/tests/%.o,fuzz/target fuzz/store_target support/files/wad_builder support/files/home_fixture \
             support/fixture)

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
$(dir)/tests/make_hostile: $(dir)/tests/support/files/hostile.o $(dir)/tests/maps/make_hostile.o
	@echo "link $@" && $(CC) $(CFLAGS_ALL) -o $@ $^ -lm
# What opens a building, without what draws or lights it.
counted := $(patsubst %.c,$(dir)/%.o,$(foreach l,$(filter-out visibility/hidden,$(filter engine/core maps% visibility%,$(layers))),$(wildcard $(l)/*.c)))
$(dir)/tests/hostile_cost: $(counted) $(dir)/tests/support/files/hostile.o $(dir)/tests/maps/hostile_cost.o
	@echo "link $@" && $(CC) $(CFLAGS_ALL) -o $@ $^ $(libs)

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
# The tests on any x86-64, and those of core, maps, visibility and sim on aarch64 (tests/portable.sh).
portable:
	$(call install,$(to_build) $(to_test) $(to_portable))
	$(submake) config=plain arch=x86-64 test
	@bash tests/portable.sh
bench: all $(filter build/maps/%,$(files))
	@mkdir -p build/bench
	$(dir)/enfilade bench $(bench) $(files) $(if $(peer),--peer $(peer)) | tee build/bench/$(bench).csv
# Measures the figures of tests/FIGURES.md and of the README again: about 15 minutes on two idle cores.
figures: all build/maps/rooms-30.plan build/maps/rooms-1000.plan build/maps/enfilade-1000.plan
	@python3 tests/make_figures.py $(dir)
# The pictures of the README; the charts show the benchmarks as `make bench` left them.
pictures:
	$(call install,$(to_build) $(to_pictures))
	$(submake) all
	@bash tests/pictures.sh $(dir)
	$(MAKE) --no-print-directory charts
charts:
	gnuplot -e "csv='build/bench/walk.csv'; out='tests/pictures/culling.png'" tests/plots/walk.gp
	@mkdir -p build/pictures
	for chart in $(filter-out walk,$(patsubst tests/plots/%.gp,%,$(wildcard tests/plots/*.gp))); do \
	    [ ! -e build/bench/$$chart.csv ] || { gnuplot -e "csv='build/bench/$$chart.csv'; out='build/pictures/$$chart'" \
	    tests/plots/$$chart.gp && cp build/pictures/$$chart.png tests/pictures; } || exit 1; done
lint:
	$(call install,$(to_lint))
	@python3 tests/check_words.py
	@echo clang-format && clang-format --dry-run -Werror $(wildcard $(layers:%=%/*.[ch]) maps/buildings/*.c tests/*/*.[ch] tests/*/*/*.[ch] tests/*/*.cpp)
	cppcheck --quiet --error-exitcode=1 --std=c11 --enable=warning,performance,portability --inline-suppr \
	    --suppress=missingIncludeSystem -I. -D__GNUC__ -j$(shell nproc) $(layers) maps/buildings
	$(submake) program
	python3 tests/structure.py $(dir)

# library.mk - the installed libraries, `make install` and `make docs`; part of the Makefile.

# The installed libraries: all below the scenes, apart by the libraries that they need in their turn.
base_layers := engine/core $(filter maps%,$(layers)) visibility $(patsubst %,visibility/%,cells soup trees query pairs prepare) engine/sim
light_layers := engine/team engine/gl $(patsubst %,visibility/%,bezier rays hidden) $(filter radiosity%,$(layers))
objects_in = $(patsubst %.c,$(dir)/%.o,$(foreach l,$(1),$(wildcard $(l)/*.c)))
base_libs := -lgeos_c -lminizip -lexpat -lwebp -lassimp -ljansson -lm
light_libs := -lembree3 -lm
version := $(shell sed -n 's/.*APP_VERSION "\(.*\)"/\1/p' engine/app/app.h)
major := $(firstword $(subst ., ,$(version)))
soname := libenfilade.so.$(major)
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
	install -m 644 $(maps) maps/README.md maps/PLAN.md LICENSE engine/NOTICES $(DESTDIR)$(PREFIX)/share/enfilade
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

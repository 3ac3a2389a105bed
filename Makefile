# SPDX-License-Identifier: BSD-3-Clause
# Everything is built below $(BUILD). `make help` lists the targets.

BUILD     ?= build
ifeq ($(strip $(BUILD)),)
$(error BUILD is empty, which would put everything into /: unset it, or name a folder)
endif
ifneq "$(BUILD)" "$(firstword $(BUILD))"
$(error BUILD is "$(BUILD)", and make takes blanks for the ends of names: name a folder without any)
endif
# `make clean` removes it.
ifneq ($(or $(filter /,$(abspath $(BUILD))),$(filter $(abspath $(BUILD))/%,$(CURDIR)/)),)
$(error BUILD is $(BUILD), where the sources are, or above them: name a folder of its own, such as build)
endif
# What asked for all of the tests would be silently the short check.
ifeq ($(origin ALL),command line)
$(error ALL is gone: run make check CI=1 for what CI runs, or make nightly for all of the tests)
endif
# make comes with a CC of its own, so ?= would have no effect.
ifeq ($(origin CC),default)
CC        := gcc
endif
PREFIX    ?= /usr/local
DESTDIR   ?=
comma     := ,
SANITIZE  ?=
VERSION   := 0.1.0
COMMIT    := $(shell git describe --always --exclude='*' --dirty=+ 2>/dev/null)
PYTHON    := /usr/bin/python3
# All processors, unless whoever called said -j.
PARALLEL   = $(if $(findstring jobserver,$(MAKEFLAGS)),,-j$(shell nproc))

# Sanitizers make gcc see what is not there, so its builds with them do not fail on warnings.
WARN      := -Wall -Wextra -Wshadow -Wconversion -Wstrict-prototypes -Wmissing-prototypes -Wvla -Wpointer-arith
WARN      += $(if $(and $(SANITIZE),$(if $(findstring clang,$(CC)),,gcc)),,-Werror)
# gcc judges vector loops (tests/support/vectorised.sh) and signs; clang asks for casts of every enum.
WARN      += $(if $(findstring clang,$(CC)),-Wno-pass-failed -Wno-sign-conversion)
# No -ffast-math: NaN must stay NaN. No contraction: the force of i on j must be minus that of j on i to the last bit.
FLOAT     := -fno-math-errno -fno-trapping-math -ffp-contract=off
# Sanitizers spend more time on compiling than tests do on running.
OPT       := $(if $(SANITIZE),-O1,-O2) -ftree-vectorize
# The solver's short loops over dimensions must be unrolled, and its blocks of eight doubles are one register where there are such. gcc clears sums
# of such blocks by string instructions, which take as long as a quarter of a particle's pairs.
X86       := $(filter x86_64%,$(shell $(CC) -dumpmachine))
CLEAR     := $(if $(X86),$(if $(findstring clang,$(CC)),,-mmemset-strategy=vector_loop:1024:noalign$(comma)libcall:-1:noalign))
HOT       := $(if $(SANITIZE),-O1,-O3) $(if $(X86),-mprefer-vector-width=512) $(CLEAR) $(if $(findstring clang,$(CC)),,-fno-loop-unroll-and-jam)
PKGS      := libzmq libprotobuf-c hdf5-serial yaml-0.1 jansson cairo libsystemd libxxhash liblz4 libzstd lua5.4 mpfr libmicrohttpd
CLIENT_PKGS := libzmq libprotobuf-c yaml-0.1 libxxhash liblz4 libzstd
# Asked once; a package that is missing is reported by the recipe of the stamps, so that `make packages` can be run.
pkg_cflags := $(shell pkg-config --cflags $(PKGS) 2>/dev/null | sed 's/-I/-isystem /g')
pkg_libs   := $(shell pkg-config --libs $(PKGS) 2>/dev/null)
client_libs := $(shell pkg-config --libs $(CLIENT_PKGS) 2>/dev/null)
# CPPFLAGS, CFLAGS, LDFLAGS and LDLIBS are the user's: they come last and win.
ifneq ($(findstring -march,$(CPPFLAGS) $(CFLAGS)),)
$(warning -march in CFLAGS: the solver is then without the loops for AVX2 and AVX-512 that it chooses from while it runs, and up to 60 % slower; leave it out)
endif
# hypre's algebraic multigrid, for large pressure systems, where it is installed; HYPRE= builds without it.
HYPRE     ?= $(wildcard /usr/include/hypre/HYPRE.h)
hypre_cflags := $(if $(HYPRE),-DHAVE_HYPRE=1 -isystem $(dir $(HYPRE)) $(shell pkg-config --cflags ompi-c 2>/dev/null | sed 's/-I/-isystem /g'))
hypre_libs := $(if $(HYPRE),-lHYPRE $(shell pkg-config --libs ompi-c 2>/dev/null))
cppflags  := -Iinclude -Iserver -I. -I$(BUILD)/gen -D_GNU_SOURCE -DMENISCUS_VERSION='"$(VERSION)"' $(pkg_cflags)
sanitize  := $(if $(SANITIZE),-fsanitize=$(SANITIZE) -fno-omit-frame-pointer -DMENISCUS_SANITIZED)
cflags    := -std=c17 -g $(OPT) $(FLOAT) -fopenmp -fPIC -ffile-prefix-map=$(CURDIR)=. $(sanitize)
ldflags   := -fopenmp -Wl,--as-needed $(sanitize)
# Where it is installed, what was compiled once is not compiled again, also from another clone: paths are relative. CCACHE= goes without.
CCACHE    ?= $(shell command -v ccache)
export CCACHE_BASEDIR ?= $(CURDIR)
compile    = $(CC) $(cppflags) $(CPPFLAGS) $(cflags)
link       = $(CC) $(ldflags) $(LDFLAGS) -o $@
# One short line for each thing made; all of it with V=1, nothing with -s.
silent     = $(findstring s,$(filter-out -%,$(firstword $(MAKEFLAGS))))
say        = $(if $(V),,@$(if $(silent),,echo "$(1) $(2)"; ))

sources    = $(sort $(foreach d,$(1),$(wildcard $(d)/*.c)))
objects    = $(patsubst %.c,$(BUILD)/obj/%.o,$(1))
GEN       := $(BUILD)/gen/case.pb-c.c $(BUILD)/gen/meniscus.pb-c.c $(BUILD)/gen/journal.pb-c.c $(BUILD)/gen/packing.pb-c.c $(BUILD)/gen/stream.pb-c.c $(BUILD)/gen/case_schema.c
SOLVER    := $(call objects,$(call sources,server/base server/sim server/sim/probes server/sim/integrators server/sim/terms server/sim/locals server/sim/solve server/sim/schemes))
COMMON    := $(call objects,$(call sources,common/case common/wire common/host)) $(patsubst $(BUILD)/gen/%.c,$(BUILD)/obj/gen/%.o,$(GEN))
DAEMON    := $(call objects,$(call sources,server/cases server/io server/run server/http server/net server/batch))
CLIENT    := $(call objects,$(call sources,client/lib)) $(BUILD)/obj/server/base/status.o
CLI       := $(call objects,$(call sources,client/cli))
DASHBOARD := $(call objects,$(filter-out %/main.c %/server.c %/files.c,$(call sources,client/dashboard)))
WEB       := client/dashboard/web
UNIT      := $(patsubst %.c,$(BUILD)/%,$(call sources,tests/unit tests/protocol))
FUZZ      := $(patsubst %.c,$(BUILD)/%,$(call sources,tests/fuzz))
TORTURE   := $(patsubst %.c,$(BUILD)/%,$(call sources,tests/torture))
BENCH     := $(patsubst %.c,$(BUILD)/%,$(call sources,tests/bench))
DASHBOARD_ALL := $(addprefix $(BUILD)/,meniscus-dashboard man/meniscus-dashboard.8)
# With the dashboard where that was built once, lest it is one of other sources.
SHIPPED   := $(addprefix $(BUILD)/shipped/,libmeniscus.a libmeniscus-client.a)
INSTALLED := all $(SHIPPED) $(if $(wildcard $(BUILD)/meniscus-dashboard),$(DASHBOARD_ALL))
MANUALS   := $(addprefix $(BUILD)/man/,meniscus.1 meniscusd.8 meniscus-case.5)
SUPPORT   := $(call objects,$(call sources,tests/support))

.PHONY: all help packages demo dashboard check nightly validate compare torture bench reference install uninstall deb pictures clean lint format asan tsan fuzz
all: $(BUILD)/meniscusd $(BUILD)/meniscus $(BUILD)/libmeniscus.a $(BUILD)/libmeniscus-client.a $(BUILD)/libmeniscus-client.so $(BUILD)/case-reference.md $(BUILD)/python/meniscus/meniscus_pb2.py $(if $(SANITIZE),,$(MANUALS)) ## build everything

help: ## list the targets
	@awk -F ':.*## ' '/^[a-z][a-z-]*:.*## / { printf "  make %-10s %s\n", $$1, $$2 }' Makefile
	@echo "variables: BUILD=$(BUILD) CC=$(CC) PREFIX=$(PREFIX) SANITIZE=$(SANITIZE) V=$(V)"
	@echo "           CPPFLAGS, CFLAGS, LDFLAGS, LDLIBS are added to ours"

packages: ## install the Debian packages that are missing
	@tools/packages.sh

demo: packages ## build, run a dam break in a daemon, stream, write HDF5, draw pictures
	@echo "Building: some minutes without a word (make all V=1 tells each)"
	@$(MAKE) --no-print-directory -s $(PARALLEL) all
	@BUILD=$(BUILD) tools/demo.sh

# What else is asked for comes first: two makes at once would write the same files.
dashboard: $(filter all tests bench-programs,$(MAKECMDGOALS)) ## build the dashboard for browsers: needs libwebsockets, and npm with its registry
	@tools/packages.sh dashboard
	@$(MAKE) --no-print-directory -s $(PARALLEL) $(DASHBOARD_ALL)

# What the tests run, and for those of CI and of the night what they need besides.
TESTED := all tests $(addprefix $(BUILD)/tests/,bench/bench_step physics/state_after physics/curvature portable/states) $(TORTURE)
TESTED_BROWSER := $(DASHBOARD_ALL) $(BUILD)/web-check/node_modules/.package-lock.json
check: ## build and test; last line: N passed, N failed [CI=1: dashboard and linters too] [TIMES=1]
	@tools/packages.sh $(if $(CI),ci,check)
	@$(MAKE) --no-print-directory -s $(PARALLEL) $(TESTED) $(if $(CI),$(TESTED_BROWSER))
	@BUILD=$(BUILD) CC=$(CC) tests/support/check.sh $(if $(CI),ci,check)

nightly: ## all of that, and what takes longer: sanitizers, fuzz targets, other processors, ParaView, Slurm, each test at its full size [TIMES=1]
	@tools/packages.sh nightly
	@$(MAKE) --no-print-directory -s $(PARALLEL) $(TESTED) $(TESTED_BROWSER) bench-programs
	@BUILD=$(BUILD) CC=$(CC) tests/support/check.sh nightly

validate: ## the papers' cases against their references [CASE="name ..."] [SIZE=paper] [JOBS=n] [CHANGED=1: those that a change has touched]
	@tools/packages.sh validate
	@$(MAKE) --no-print-directory -s $(PARALLEL) all $(addprefix $(BUILD)/tests/physics/,state_after curvature)
	@BUILD=$(BUILD) $(PYTHON) tests/physics/validate.py $(if $(CASE),--case $(CASE)) $(if $(SIZE),--size $(SIZE)) $(if $(JOBS),--jobs $(JOBS)) \
	    $(if $(CHANGED),--changed)

compare: ## the schemes side by side on the same cases [CASE=name] [JOBS=n]
	@tools/packages.sh validate
	@$(MAKE) --no-print-directory -s $(PARALLEL) all
	@BUILD=$(BUILD) $(PYTHON) tests/physics/compare.py $(if $(CASE),--case $(CASE)) $(if $(JOBS),--jobs $(JOBS))

bench: ## benchmarks as JSON lines [SIZE=full: those of up to four million particles too]
	@tools/packages.sh bench >&2
	@$(MAKE) --no-print-directory -s $(PARALLEL) bench-programs >&2
	@for b in $(BENCH); do $$b || exit 1; done
	@$(if $(filter full,$(SIZE)),$(BUILD)/tests/bench/bench_step large)
	@for b in $(wildcard tests/bench/*.py); do BUILD=$(BUILD) $(PYTHON) $$b || exit 1; done

torture: ## the control plane against its promises: 15 minutes [ROW=name] [SIZE=full]
	@tools/packages.sh ci
	@$(MAKE) --no-print-directory -s $(PARALLEL) all torture-programs
	@BUILD=$(BUILD) $(PYTHON) tests/torture/torture.py $(ROW) $(if $(SIZE),--size $(SIZE))

.PHONY: tests raced bench-programs states states-objects torture-programs fuzz-programs flags solver-flags solver-libs
# All programs there are run, so there are none whose source is gone.
others = $(filter-out $1,$(wildcard $(BUILD)/tests/unit/* $(BUILD)/tests/protocol/*))
tests: $(UNIT)
	@rm -f $(call others,$(UNIT))
# Where there can be races: the team of the solver, and the threads of the daemon.
RACED := $(filter $(BUILD)/tests/protocol/% $(addprefix $(BUILD)/tests/unit/test_,belts build edges energy fault figures guard mailbox mirrors neighbours probe restart steer wall writer),$(UNIT))
# What clang warns of is looked for in all of the tests.
raced: all $(RACED) $(patsubst $(BUILD)/tests/%,$(BUILD)/obj/tests/%.o,$(UNIT))
	@rm -f $(call others,$(RACED))
bench-programs: all $(BENCH) $(BUILD)/tests/physics/state_after
# What all machines compute, and for machines whose libraries are not here (tests/portable/aarch64.sh).
states: $(BUILD)/tests/portable/states
states-objects: $(filter-out %/formula.o,$(SOLVER)) $(call objects,tests/support/bench_cases.c tests/support/cases.c $(wildcard tests/portable/*.c))
# What is fed rubbish is built with sanitizers.
torture-programs: $(TORTURE) $(BUILD)/tests/protocol/test_daemon_fuzz
	@$(MAKE) --no-print-directory -s $(PARALLEL) BUILD=$(BUILD)/fuzz CC=clang SANITIZE=$(FUZZED) fuzz-programs
FUZZED    := address,undefined,fuzzer-no-link
fuzz-programs: $(FUZZ)

reference: $(BUILD)/case-reference.md ## write the manual of the case format from its schema
	cp $< server/cases/REFERENCE.md

asan: ## unit and protocol tests under address and undefined-behaviour sanitizers
	@tools/packages.sh ci
	@$(MAKE) --no-print-directory -s $(PARALLEL) BUILD=$(BUILD)/asan SANITIZE=address,undefined all tests
	@BUILD=$(BUILD)/asan tests/support/sanitize.sh address

tsan: ## the same under the thread sanitizer (clang, libomp)
	@tools/packages.sh ci
	@$(MAKE) --no-print-directory -s $(PARALLEL) BUILD=$(BUILD)/tsan CC=clang SANITIZE=thread raced
	@BUILD=$(BUILD)/tsan tests/support/sanitize.sh thread

fuzz: ## what comes from outside, under libFuzzer (clang) [FUZZ_SECONDS=600, for each target]
	@tools/packages.sh ci
	@$(MAKE) --no-print-directory -s $(PARALLEL) BUILD=$(BUILD)/fuzz CC=clang SANITIZE=$(FUZZED) fuzz-programs
	@BUILD=$(BUILD)/fuzz tests/support/fuzz.sh $(or $(FUZZ_SECONDS),600)

lint: ## clang-format, clang-tidy, cppcheck, shellcheck, layers
	@tools/packages.sh ci
	@$(MAKE) --no-print-directory -s $(PARALLEL) all $(BUILD)/web-check/node_modules/.package-lock.json
	@BUILD=$(BUILD) tests/support/layers.sh
	@BUILD=$(BUILD) tests/support/headers.sh
	@BUILD=$(BUILD) tests/support/lint.sh

flags: # the preprocessor's, quoted for a shell: for the scripts of tests/support
	$(info $(cppflags) $(hypre_cflags) $(CPPFLAGS))@:

solver-flags: # with which the solver is compiled
	$(info $(cflags) $(HOT))@:

solver-libs: # that the solver needs besides those of its .pc file
	$(info $(hypre_libs))@:

pictures: ## draw those of the README again: some minutes
	@tools/packages.sh pictures
	@$(MAKE) --no-print-directory -s $(PARALLEL) all $(DASHBOARD_ALL) $(BUILD)/web-check/node_modules/.package-lock.json
	@BUILD=$(BUILD) tools/pictures.sh

format: ## lay out the sources
	clang-format -i $$(git ls-files '*.c' '*.h')

install: $(INSTALLED) ## install below $(DESTDIR)$(PREFIX)
	DESTDIR=$(DESTDIR) PREFIX=$(PREFIX) BUILD=$(BUILD) VERSION=$(VERSION) tools/install.sh install

uninstall: ## remove what install put there
	DESTDIR=$(DESTDIR) PREFIX=$(PREFIX) BUILD=$(BUILD) VERSION=$(VERSION) tools/install.sh uninstall

deb: ## a Debian package, with the dashboard where that was built; DEBFULLNAME and DEBEMAIL say whose
	@tools/packages.sh deb
	@$(MAKE) --no-print-directory -s $(PARALLEL) $(INSTALLED)
	@BUILD=$(BUILD) VERSION=$(VERSION) tools/deb.sh

clean: ## remove the build
	rm -rf $(BUILD)

# --- programs and libraries ---------------------------------------------------------------------------------------------
$(BUILD)/obj/server/sim/solve/amg.o: private cppflags += $(hypre_cflags)
$(BUILD)/meniscusd: $(BUILD)/obj/server/main.o $(DAEMON) $(BUILD)/libmeniscus.a $(BUILD)/libmeniscus-common.a $(BUILD)/stamp/sources
	$(call say,LINK,$@)$(link) $(filter-out %/sources,$^) $(pkg_libs) $(hypre_libs) -lm -lpthread $(LDLIBS)
$(BUILD)/meniscus: $(CLI) $(BUILD)/libmeniscus-client.a $(BUILD)/stamp/sources
	$(call say,LINK,$@)$(link) $(filter-out %/sources,$^) $(pkg_libs) -lm -lpthread $(LDLIBS)
# Not of `all`: its front end is bundled from npm, which fresh machines have not. What the linker makes of files is named after their paths.
$(BUILD)/meniscus-dashboard: $(patsubst %,$(BUILD)/obj/client/dashboard/%.o,main server files) $(BUILD)/obj/web.o $(BUILD)/libmeniscus-dashboard.a \
    $(BUILD)/libmeniscus-cli.a $(BUILD)/libmeniscus-client.a
	$(call say,LINK,$@)$(link) $^ $(pkg_libs) $(shell pkg-config --libs libwebsockets) -lm -lpthread $(LDLIBS)
$(BUILD)/obj/web.o: $(BUILD)/web/app.js
	$(call say,LD,$@)cd $(BUILD)/web && $(shell $(CC) -print-prog-name=ld) -r -b binary -z noexecstack -o ../obj/web.o index.html app.js app.css icon.svg
$(BUILD)/web/app.js: $(wildcard $(WEB)/src/*) $(BUILD)/web/node_modules/.package-lock.json
	$(call say,BUNDLE,$@)cp $(WEB)/src/index.html $(WEB)/src/icon.svg $(BUILD)/web && NODE_PATH=$(BUILD)/web/node_modules \
	    node $(BUILD)/web/node_modules/esbuild/bin/esbuild $(WEB)/src/app.js --bundle --minify --format=esm --target=es2022 \
	    --legal-comments=inline --log-level=warning --outfile=$@
# Exactly what the lock file says; for the tests a browser's remote control besides.
$(BUILD)/web/node_modules/.package-lock.json: private npm_flags := --omit=dev
$(BUILD)/%/node_modules/.package-lock.json: $(WEB)/package.json $(WEB)/package-lock.json $(WEB)/.npmrc
	@mkdir -p $(BUILD)/$*
	$(call say,NPM,$(@D))cp $^ $(BUILD)/$* && cd $(BUILD)/$* && npm ci --silent $(npm_flags) && touch node_modules/.package-lock.json
$(BUILD)/libmeniscus.a: $(SOLVER)
$(BUILD)/libmeniscus-common.a: $(COMMON)
$(BUILD)/libmeniscus-client.a: $(CLIENT) $(COMMON)
$(BUILD)/libmeniscus-dashboard.a: $(DASHBOARD)
$(BUILD)/libmeniscusd.a: $(DAEMON)
$(BUILD)/libmeniscus-cli.a: $(filter-out %/main.o,$(CLI))
$(BUILD)/%.a: $(BUILD)/stamp/sources
	$(call say,AR,$@)rm -f $@ && $(AR) rcs $@ $(filter %.o,$^)
# For programs of others: one object, which shows what its headers tell of and keeps our own names from theirs. C's mathematics stay, as
# formulas are to have them too.
$(BUILD)/shipped/%.a: $(BUILD)/%.a
	@mkdir -p $(@D)
	$(call say,AR,$@)$(CC) -r -nostdlib -o $(@:.a=.o) -Wl,--whole-archive $< -Wl,--no-whole-archive && \
	    objcopy --wildcard --keep-global-symbol='mns_*' $$(nm -g --defined-only $(BUILD)/obj/server/base/elementary.o | \
	    sed -n 's/.* /--keep-global-symbol=/p') $(@:.a=.o) && rm -f $@ && $(AR) rcs $@ $(@:.a=.o)
$(BUILD)/libmeniscus-client.so: $(CLIENT) $(COMMON) client/lib/exports.map $(BUILD)/stamp/sources
	$(call say,LINK,$@)$(link) -shared -Wl,-soname,$(@F).$(firstword $(subst ., ,$(VERSION))) -Wl,--version-script=client/lib/exports.map \
	    $(filter %.o,$^) $(client_libs) -lm $(LDLIBS)
# Unit and protocol tests are many: each with all of it linked in would be three gigabytes, and twice that with a sanitizer.
$(BUILD)/libmeniscus-tests.so: $(sort $(SUPPORT) $(SOLVER) $(COMMON) $(DAEMON) $(CLIENT) $(DASHBOARD) $(filter-out %/main.o,$(CLI))) $(BUILD)/stamp/sources
	$(call say,LINK,$@)$(link) -shared -Wl,-soname,$(@F) $(filter %.o,$^) $(pkg_libs) $(hypre_libs) -lm -lpthread -lcmocka $(LDLIBS)
$(UNIT): $(BUILD)/%: $(BUILD)/obj/%.o $(BUILD)/libmeniscus-tests.so
	@mkdir -p $(@D)
	$(call say,LINK,$@)$(link) $^ -Wl,-rpath,'$$ORIGIN/../..' $(pkg_libs) -lm -lpthread -lcmocka $(LDLIBS)
$(BUILD)/tests/%: $(BUILD)/obj/tests/%.o $(SUPPORT) $(BUILD)/libmeniscus-dashboard.a $(BUILD)/libmeniscus-cli.a $(BUILD)/libmeniscus-client.a $(BUILD)/libmeniscusd.a $(BUILD)/libmeniscus.a $(BUILD)/libmeniscus-common.a
	@mkdir -p $(@D)
	$(call say,LINK,$@)$(link) $< $(SUPPORT) -Wl,--start-group $(filter %.a,$^) -Wl,--end-group $(pkg_libs) $(hypre_libs) -lm -lpthread -lcmocka $(LDLIBS)
# With no more than they look at: libFuzzer goes through counters of all that is linked after each input.
$(BUILD)/tests/fuzz/fuzz_checkpoint: $(BUILD)/obj/tests/support/cases.o
$(BUILD)/tests/fuzz/%: $(BUILD)/obj/tests/fuzz/%.o $(BUILD)/libmeniscusd.a $(BUILD)/libmeniscus.a $(BUILD)/libmeniscus-common.a
	@mkdir -p $(@D)
	$(call say,LINK,$@)$(link) -fsanitize=fuzzer $(filter %.o,$^) -Wl,--start-group $(filter %.a,$^) -Wl,--end-group $(pkg_libs) $(hypre_libs) -lm -lpthread $(LDLIBS)

# --- objects and generated sources --------------------------------------------------------------------------------------
$(SOLVER): private cflags += $(HOT)
$(BUILD)/obj/common/wire/packing_numbers.o: private cflags += $(if $(SANITIZE),-O1,-O3)
$(BUILD)/obj/server/net/describe.o: private cppflags += -DMENISCUS_COMMIT='"$(COMMIT)"'
$(BUILD)/obj/server/net/describe.o: $(BUILD)/stamp/commit
$(BUILD)/obj/%.o: %.c $(BUILD)/stamp/flags | $(GEN) $(BUILD)/gen/sim/case_bounds.h
	@mkdir -p $(@D)
	$(call say,CC,$<)$(CCACHE) $(compile) $(WARN) $(CFLAGS) -MMD -MP -c -o $@ $<
$(BUILD)/obj/gen/%.o: $(BUILD)/gen/%.c $(BUILD)/stamp/flags | $(GEN)
	@mkdir -p $(@D)
	$(call say,CC,$<)$(CCACHE) $(compile) $(CFLAGS) -MMD -MP -c -o $@ $<
# The headers too, as who includes one is stale with it.
$(BUILD)/gen/%.pb-c.c $(BUILD)/gen/%.pb-c.h: proto/%.proto $(wildcard proto/*.proto) | $(BUILD)/stamp/flags
	@mkdir -p $(@D)
	$(call say,GEN,$@)protoc-c -Iproto --c_out=$(@D) $<
$(BUILD)/gen/case_schema.c $(BUILD)/gen/sim/case_bounds.h $(BUILD)/case-reference.md &: proto/case.proto proto/schema.py proto/manual.md | $(BUILD)/stamp/flags
	@mkdir -p $(BUILD)/gen/sim
	$(call say,GEN,$(BUILD)/gen/case_schema.c)protoc -Iproto --include_source_info --descriptor_set_out=$(BUILD)/gen/case.desc proto/case.proto \
	    && $(PYTHON) proto/schema.py $(BUILD)/gen/case.desc $(BUILD)/gen/case_schema.c $(BUILD)/gen/sim/case_bounds.h $(BUILD)/case-reference.md
# Manual pages are what the programs say of themselves.
$(MANUALS) &: client/cli/manual.py client/README.md $(BUILD)/meniscus $(BUILD)/meniscusd $(BUILD)/case-reference.md
	@mkdir -p $(BUILD)/man
	$(call say,GEN,$(BUILD)/man)$(PYTHON) client/cli/manual.py $(BUILD) $(notdir $(MANUALS))
$(BUILD)/man/meniscus-dashboard.8: client/cli/manual.py client/dashboard/README.md $(BUILD)/meniscus $(BUILD)/meniscus-dashboard
	@mkdir -p $(BUILD)/man
	$(call say,GEN,$@)$(PYTHON) client/cli/manual.py $(BUILD) $(@F)
# The Python client with its generated modules, for PYTHONPATH=$(BUILD)/python; client/python/setup.py does the same for pip.
PY_FILES := $(wildcard client/python/src/meniscus/*.py) client/python/src/meniscus/py.typed
$(BUILD)/python/meniscus/meniscus_pb2.py: client/python/generate.py $(PY_FILES) $(wildcard proto/*.proto) | $(BUILD)/stamp/flags
	@mkdir -p $(@D)
	$(call say,GEN,$(@D))$(PYTHON) client/python/generate.py proto $(@D) && cp $(PY_FILES) $(@D)

# --- stamps: written only when what they hold has changed, and then all that depends on it is made again ------------------
$(BUILD)/stamp/flags: export STAMP = $(compile) $(HOT) $(hypre_cflags) $(WARN) $(CFLAGS) $(link) $(pkg_libs) $(hypre_libs) $(client_libs) $(LDLIBS)
$(BUILD)/stamp/commit: export STAMP = $(COMMIT)
$(BUILD)/stamp/sources: export STAMP = $(SOLVER) $(COMMON) $(DAEMON) $(CLIENT) $(CLI) $(DASHBOARD)
$(BUILD)/stamp/%: FORCE
	@for tool in pkg-config protoc protoc-c; do command -v $$tool >/dev/null || { echo "$$tool is missing: run make packages" >&2; exit 1; }; done
	@pkg-config --exists $(PKGS) || { echo "packages are missing ($(PKGS)): run make packages" >&2; exit 1; }
	@mkdir -p $(@D)
	@printf '%s\n' "$$STAMP" | cmp -s - $@ || printf '%s\n' "$$STAMP" >$@
.PHONY: FORCE
FORCE:

.SECONDARY:
-include $(shell find $(BUILD)/obj -name '*.d' 2>/dev/null)

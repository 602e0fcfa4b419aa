# demo and test install what a fresh Debian or Ubuntu machine with Rust lacks; everything shares one cargo profile and
# one target folder, so that shaderc and the dependencies compile once (some eight minutes on two cores).

CARGO ?= cargo
RUN = $(CARGO) run --release --locked --quiet --
TEST = $(CARGO) test --release --locked
# Where `make install` puts things.
PREFIX ?= $(HOME)/.local
# What `make fuzz` gives: seconds for each of the six kinds of file, and random cases for each property.
TIME ?= 600
CASES ?= 20000

# In the order of docs/species.md.
SPECIES = oak beech spruce pine palm dead shrub fern grass tussock daisy poppy

# Pictures of worlds, as docs/pictures/forest_NAME.png.
FORESTS = default=forest/default dead=forest/dead mountain=forest/mountain reef=landscape/reef_forest

# Worlds on the viewer's first page, as docs/pictures/small/KIND_NAME.png.
SMALL = island/volcano island/atoll island/dendritic island/old_barrier island/tiny forest/default forest/mountain \
	forest/dead forest/tiny landscape/reef_forest zoom/descent zoom/thesis

.PHONY: help demo view species forests zooms small windows install test test-long bench fuzz lint headless doc

help:
	@echo 'make demo       build, and render an island to out/volcano.png and a wooded one to out/reef_forest.png'
	@echo 'make view       build, and open the viewer'
	@echo 'make species    pictures of all species, in docs/pictures'
	@echo 'make forests    pictures of the forests, in docs/pictures: takes minutes, and oidnDenoise'
	@echo 'make zooms      pictures of one flight at five depths, in docs/pictures'
	@echo 'make install    the program, its manual and completions for shells, below PREFIX=$(PREFIX)'
	@echo 'make test       the test suite, on the Vulkan device that is found (lavapipe will do)'
	@echo 'make test-long  the tests that take too long for every change'
	@echo 'make bench      how fast land is made here, as docs/benches.md shows it'
	@echo 'make fuzz       the readers of files against damaged ones, TIME=$(TIME) seconds for each kind: an hour in all'
	@echo 'make small      small pictures of worlds, for the first page of the viewer'
	@echo 'make windows    pictures of the viewer, in docs/pictures: needs a display'
	@echo 'make lint       formatting and clippy, warnings denied'
	@echo 'make headless   the same of the program without windows'
	@echo 'make doc        the documentation of the library, warnings denied'

demo:
	@scripts/install.sh
	@echo 'Building: the first time takes some minutes, most of them for the shader compiler.'
	$(CARGO) build --release --locked
	@mkdir -p out
	$(RUN) render configs/island/volcano.toml -o out/volcano.png
	$(RUN) render configs/landscape/reef_forest.toml --size 320x180 --spp 16 -o out/reef_forest.png
	@echo 'The pictures are out/volcano.png and, path traced, out/reef_forest.png.'

view:
	@scripts/install.sh
	$(RUN) view

small:
	@scripts/install.sh
	set -e; for world in $(SMALL); do \
		renderer='--renderer raster'; case $$world in zoom/*) renderer=;; esac; \
		$(RUN) render configs/$$world.toml --size 256x144 $$renderer \
			-o docs/pictures/small/$$(echo $$world | tr / _).png; \
	done

# Needs a display.
windows:
	@scripts/install.sh
	@mkdir -p out
	set -e; for window in 'island/volcano push Section\nwait 1200\npush Pause\nwait quiet\nmove 760 420\nwait quiet' \
			'forest/default push Simulation\npush Plants\nwait quiet\nclick 640 330\nwait quiet' \
			'zoom/descent wait 40\npush Stop\npush Drawing\nwait quiet'; do \
		world=$${window%% *}; picture=docs/pictures/window_$${world%%/*}.png; \
		printf "$${window#* }\nwait 10\nscreenshot $$picture\nquit\n" > out/acts.txt; \
		$(RUN) view configs/$$world.toml --size 1200x750 --script out/acts.txt; \
	done

species:
	@scripts/install.sh
	$(RUN) plant $(SPECIES:%=configs/species/%.toml) -o docs/pictures/species.png --size 200x240
	$(RUN) plant $(sort $(wildcard configs/species/abop_*.toml configs/species/honda_*.toml)) \
		-o docs/pictures/species_of_the_book.png --size 136x164

forests:
	@scripts/install.sh
	set -e; for forest in $(FORESTS); do \
		$(RUN) render configs/$${forest#*=}.toml -o docs/pictures/forest_$${forest%%=*}.png --size 800x450 \
			--renderer raster; \
	done
	$(RUN) render configs/landscape/reef_forest.toml --size 640x360 --spp 8 --denoise -o docs/pictures/traced_reef.png

zooms:
	@scripts/install.sh
	set -e; for depth in 0 10 100 1000 10000; do \
		$(RUN) render configs/zoom/descent.toml --set zoom.depth=$$depth --size 640x360 -o docs/pictures/zoom_$$depth.png; \
	done

install:
	@scripts/install.sh
	$(CARGO) install --path . --locked --root $(PREFIX)
	@mkdir -p $(PREFIX)/share/man/man1 $(PREFIX)/share/bash-completion/completions \
		$(PREFIX)/share/zsh/site-functions $(PREFIX)/share/fish/vendor_completions.d
	$(PREFIX)/bin/terrane man -o $(PREFIX)/share/man/man1
	$(PREFIX)/bin/terrane completions bash > $(PREFIX)/share/bash-completion/completions/terrane
	$(PREFIX)/bin/terrane completions zsh > $(PREFIX)/share/zsh/site-functions/_terrane
	$(PREFIX)/bin/terrane completions fish > $(PREFIX)/share/fish/vendor_completions.d/terrane.fish

test:
	@scripts/install.sh validation
	$(TEST)

test-long:
	@scripts/install.sh validation readers
	$(TEST) --tests -- --ignored --nocapture --test-threads 1
	$(TEST) --features reload --test viewer reload

bench:
	@scripts/install.sh
	@date +%F
	$(CARGO) bench --locked --quiet

fuzz:
	@scripts/install.sh
	TERRANE_FUZZ_SECONDS=$(TIME) TERRANE_FUZZ_SEED=$$(date +%s) PROPTEST_CASES=$(CASES) $(TEST) --tests fuzz -- --nocapture

headless:
	$(CARGO) clippy --release --locked --lib --bins --no-default-features -- -D warnings

lint:
	$(CARGO) fmt --check
	$(CARGO) clippy --release --locked --all-targets -- -D warnings

doc:
	RUSTDOCFLAGS='-D warnings' $(CARGO) doc --release --locked --no-deps

"""What goes wrong at the start is one error that says what to do."""

from golden import Golden
from nrp_conformance.world.kit import robot
from nrp_world_gazebo import GazeboBackend

from nrp_core.errors import BackendLoadError
from nrp_core.world import Inertial, Link, Model, Scene

SCENE = Scene((Model("box", (Link("link", inertial=Inertial(1.0)),)),))


def opened(scene=SCENE, **options):
    backend = GazeboBackend()
    chosen = backend.options.model_validate({"root": None, **options})
    return backend.open(scene, seed=1, options=chosen)


def test_a_missing_program_is_named_with_the_remedy(golden: Golden):
    with golden.raises(BackendLoadError, match="'gzserver-12'"):
        opened(command="gzserver-12")


def test_a_root_that_is_not_a_system_is_named(tmp_path, golden: Golden):
    with golden.raises(BackendLoadError, match=f"{tmp_path}"):
        opened(root=tmp_path)


def test_a_folder_with_too_long_a_name_for_a_socket_is_named(tmp_path, monkeypatch, golden: Golden):
    folder = tmp_path / ("x" * 90)
    folder.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(folder))
    with golden.raises(BackendLoadError, match=f"{folder}.*TMPDIR=/tmp"):
        opened(command="sh")
    assert not list(folder.iterdir())


def test_a_program_that_ends_is_quoted_with_its_last_line(golden: Golden):
    with golden.raises(BackendLoadError, match=r"3:\s+\[Err\]") as caught:
        opened(
            command=(
                "sh",
                "-c",
                "echo '[Err] no world' >&2; echo '[Err] [OpenAL.cc:84] mute'; seq 3; exit $((1 + 2))",
            )
        )
    assert "\n  3" not in str(caught.value)  # the other lines
    assert "\n  [Err] [OpenAL" not in str(caught.value)


def test_a_program_that_never_connects_is_given_up(golden: Golden):
    with golden.raises(BackendLoadError, match=r"0\.2"):
        opened(command=("sh", "-c", "sleep 30"), start_timeout=0.2)


def missing(plugin):
    """A program that reports as Gazebo does that a plugin is missing."""
    told = f"[Err] [Plugin.hh:178] Failed to load plugin {plugin}: {plugin}: cannot open shared object file"
    return "sh", "-c", f"echo '{told}'; exec sleep 30"


def test_a_program_without_the_plugin_is_not_waited_for(golden: Golden):
    with golden.raises(BackendLoadError, match=r"libnrp_gazebo\.so"):
        opened(command=missing("libnrp_gazebo.so"))


def test_a_missing_plugin_of_a_users_file_does_not_keep_it_from_starting(golden: Golden):
    with golden.raises(BackendLoadError, match=r"0\.3.*libgazebo_ros_laser\.so"):
        opened(command=missing("libgazebo_ros_laser.so"), start_timeout=0.3)


def test_a_port_that_was_taken_meanwhile_is_changed(tmp_path, golden: Golden):
    taken = "echo 'Unable to start server[bind: Address already in use].' >&2"
    tried = tmp_path / "tried"
    third = f"[ $(wc -l < {tried}) -gt 2 ]"
    script = f'echo "$GAZEBO_MASTER_URI" >> {tried}; {third} || {{ {taken}; exit 255; }}; exit 7'
    with golden.raises(BackendLoadError):
        opened(command=("sh", "-c", script))
    assert len(set(tried.read_text().split())) == 3


def test_a_port_that_is_always_taken_is_one_error(golden: Golden):
    with golden.raises(BackendLoadError, match=r"3 times:\s+"):
        opened(command=("sh", "-c", "echo 'bind: Address already in use' >&2; exec sleep 30"))


def test_images_without_a_display_are_refused_with_the_remedy(tmp_path, monkeypatch, golden: Golden):
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.setenv("PATH", str(tmp_path))
    with golden.raises(BackendLoadError):
        opened(Scene((robot(),)), renderer="gazebo")

"""The page about Gymnasium, with a real library of learning."""

import re
from pathlib import Path
from typing import Any

import pytest

PAGE = Path(__file__).parents[4] / "docs" / "howto" / "train-with-gymnasium.md"


@pytest.mark.heavy
@pytest.mark.slow
def test_ppo_trains_as_the_page_says(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    learning = pytest.importorskip("stable_baselines3", reason="pip install stable-baselines3")
    blocks = re.findall(r"```python\n(.*?)```", PAGE.read_text(), re.DOTALL)
    (wrappers,) = (block for block in blocks if block.startswith("# flat.py"))
    (training,) = (block for block in blocks if "import PPO" in block)
    assert "20_000" in training
    (tmp_path / "flat.py").write_text(wrappers)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    made: dict[str, Any] = {}
    exec(training.replace("20_000", "512"), made)
    trained = made["model"]
    assert trained.num_timesteps == 512
    saved = learning.PPO.load("slalom").policy.state_dict()
    begun = learning.PPO("MlpPolicy", trained.env, n_steps=512, seed=1).policy.state_dict()
    assert any((saved[name] != begun[name]).any() for name in begun), "the policy has not learned"
    assert all((saved[name] == value).all() for name, value in trained.policy.state_dict().items())
    trained.env.close()

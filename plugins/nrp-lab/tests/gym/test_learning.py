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
    (training,) = (block for block in blocks if "import PPO" in block)
    assert "20_000" in training
    monkeypatch.chdir(tmp_path)
    made: dict[str, Any] = {}
    exec(training.replace("20_000", "480"), made)
    trained = made["model"]
    assert trained.num_timesteps == 480
    saved = learning.PPO.load("pioneer").policy.state_dict()
    begun = learning.PPO("MlpPolicy", trained.env, n_steps=30, batch_size=60, seed=1).policy.state_dict()
    assert any((saved[name] != begun[name]).any() for name in begun), "the policy has not learned"
    assert all((saved[name] == value).all() for name, value in trained.policy.state_dict().items())
    trained.env.close()

import ftac_gym

env = ftac_gym.make("SpacecraftFTC-v0")  # gymnasium.make with types; that works too
controller = ftac_gym.baselines.make("pd_dob", env.scenario).as_policy(env)
observation, info = env.reset(seed=0)
done = False
while not done:
    action, _ = controller.predict(observation)
    observation, reward, terminated, truncated, info = env.step(action)
    done = terminated or truncated
print(info["attitude_error"], info["is_success"])  # noqa: T201  [deg], on target at the end
